// A sequence of frames as a stream of lexical descriptors.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estancia/core/descriptor.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/label/labeler.hpp"

namespace estancia {

struct LabelStreamOptions {
  std::size_t first = 0;  ///< frame to start with: to continue where an earlier run stopped
  bool strict = false;    ///< an unreadable frame ends the stream with its Error instead of being reported
  std::size_t ahead =
      4;  ///< frames decoded ahead of inference; each holds its image, so memory stays bounded
};

struct LabelledFrame {
  std::size_t index = 0;         ///< in the sequence
  LexicalDescriptor descriptor;  ///< empty when the frame cannot be read
  cv::Mat image;                 ///< as Sequence::image() gave it; empty when the frame cannot be read
  std::string problem;           ///< why it cannot be read, one sentence; "" when all is well

  bool labelled() const { return problem.empty(); }
};

/// Labels the frames of a sequence in order. One background thread decodes and prepares the next frames while
/// the caller's thread infers, so the whole runs at the network's own speed. Sequence and labeler must
/// outlive the stream.
class LabelStream {
 public:
  LabelStream(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {});

  /// Stops the background thread; at any time.
  ~LabelStream();
  LabelStream(const LabelStream&) = delete;
  LabelStream& operator=(const LabelStream&) = delete;

  /// The next frame, or nothing after the last. Throws what inference throws, and what the sequence throws
  /// other than an Error about one frame (with `strict`: that too); after an exception the stream is at its
  /// end.
  std::optional<LabelledFrame> next();

 private:
  class Reader;
  Labeler& labeler_;
  std::unique_ptr<Reader> reader_;
};

}  // namespace estancia
