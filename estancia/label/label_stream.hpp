// A sequence's frames, labeled in order; decoding runs ahead of the network, and nothing is labeled twice.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estancia/core/descriptor.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/label/label_cache.hpp"
#include "estancia/label/labeler.hpp"

namespace estancia {

struct LabelStreamOptions {
  std::size_t first = 0;        ///< where to start
  bool strict = false;          ///< throw Error at an unreadable frame instead of reporting it
  std::size_t ahead = 16;       ///< frames prepared ahead; each holds its image, so memory stays bounded
  std::size_t readers = 2;      ///< threads that decode and prepare
  LabelCache* cache = nullptr;  ///< looked into first and added to; must outlive the stream
};

struct LabeledFrame {
  std::size_t index = 0;         ///< in the sequence
  LexicalDescriptor descriptor;  ///< empty when the frame has no words
  cv::Mat image;        ///< as Sequence::image() gave it; empty when it was not needed or cannot be read
  std::string problem;  ///< why the frame has no words, one sentence; "" when all is well

  bool remembered = false;  ///< its words were in the cache: nobody looked at the image

  bool labeled() const { return problem.empty(); }
};

/// Labels the frames of a sequence in order. Background threads decode and prepare the next frames while
/// the caller's thread infers, so the whole runs at the network's own speed. Sequence and labeler must
/// outlive the stream.
class LabelStream {
 public:
  LabelStream(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options = {});

  /// Stops the background threads; at any time.
  ~LabelStream();
  LabelStream(const LabelStream&) = delete;
  LabelStream& operator=(const LabelStream&) = delete;

  /// The next frame, or nothing after the last. Throws what inference throws, and what the sequence throws
  /// that is not one frame's failure (see frameFailure(); with `strict`: that too); after an exception the
  /// stream is at its end. When the labeler discovers words, earlier descriptors are shorter than later ones.
  std::optional<LabeledFrame> next();

 private:
  class Reader;
  class Inference;
  std::unique_ptr<Inference> inference_;
  std::unique_ptr<Reader> reader_;  // last: its threads use the labeler
};

}  // namespace estancia
