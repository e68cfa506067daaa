// Label stream: labels the frames of a sequence in order; decoding runs ahead, cached labels are reused.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estancia/core/descriptor.hpp"
#include "estancia/label/label_cache.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

class OptionGroup;

struct LabelStreamOptions {
  /// The first frame to label.
  std::size_t first = 0;
  /// Throw Error at an unreadable frame instead of reporting it.
  bool strict = false;
  /// Frames prepared ahead; each holds its image, so memory stays bounded.
  std::size_t ahead = 16;
  /// Threads that decode and prepare.
  std::size_t readers = 2;
  /// Looked into first and added to; must outlive the stream.
  LabelCache* cache = nullptr;
};

OptionGroup declare(LabelStreamOptions& options);

/// A frame with its labels, or the reason why it has none.
struct LabeledFrame {
  /// In the sequence.
  std::size_t index = 0;
  /// Empty when the frame has no words.
  LexicalDescriptor descriptor;
  /// Image from Sequence::image(); empty when it was not needed (also when the network saw it reduced) or
  /// cannot be read.
  cv::Mat image;
  /// Why the frame has no words, one sentence; "" when all is well.
  std::string problem;

  /// Its words were in the cache: the image was not labeled.
  bool remembered = false;

  bool labeled() const { return problem.empty(); }
};

/// Labels the frames of a sequence in order. Background threads decode and prepare the next frames while
/// the caller's thread infers, so that the stream runs at the network's speed. Sequence and labeler must
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
