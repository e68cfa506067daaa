// Labeler: the interface of everything that turns an image into label probabilities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Result of Labeler::prepare() for a frame; only the labeler that made it can read it.
struct Prepared {
  cv::Mat input;
  /// The frame's name in its sequence; "" outside of sequences.
  std::string frame;
  /// Prepared inputs of the members of an ensemble.
  std::vector<Prepared> members;
};

/// The answer for one frame of a batch.
struct LabelResult {
  /// Empty when there is a problem.
  LexicalDescriptor descriptor;
  /// Why this frame has no words, one sentence; "" when all is well.
  std::string problem;
};

/// Thrown when one frame cannot be labeled but the next may be; any other Error ends the work. What is no
/// Error at all is one frame's failure, too (see frameFailure()).
class FrameError : public Error {
 public:
  explicit FrameError(const std::string& sentence) : Error(ErrorCode::labelerFailure, sentence) {}
};

/// Thrown by inferBatch() when the work must end, with what is known by then: the answers of the batch, in
/// order, where frames without one have neither descriptor nor problem.
class BatchError : public Error {
 public:
  BatchError(const Error& cause, std::vector<LabelResult> known) : Error(cause), results(std::move(known)) {}
  std::vector<LabelResult> results;
};

/// Anything that gives an image's labels with probabilities (thesis 1.6): a CNN, several, a service, a
/// person. Labeling has two steps so that a stream can prepare the next images while some are inferred.
class Labeler {
 public:
  virtual ~Labeler() = default;

  virtual const Vocabulary& vocabulary() const = 0;

  /// Whether words are discovered on the way (services): vocabulary() then grows at its end with every new
  /// word, a descriptor has as many values as there were words when it was made, and later words are 0 in it.
  virtual bool discovers() const { return false; }
  /// The descriptor of words that are known from elsewhere (a cache), which may be new. For labelers that
  /// discover.
  virtual LexicalDescriptor adopt(std::span<const LabelProbability> words);

  /// Identifies the model for maps: name and digest of its files.
  virtual std::string identity() const = 0;

  /// Identifies the numbers for caches: the identity, and whatever changes their last digits (the engine).
  virtual std::string cacheKey() const { return identity(); }

  /// Whether prepare() looks at the image at all; recordings go by the frame's name.
  virtual bool needsImage() const { return true; }

  /// The shorter side [pixels] of the smallest image that prepare() need not enlarge, where JPEG files are to
  /// be decoded at no more than it takes (Sequence::reducedImage()); 0 where it wants whole images.
  virtual int imageSide() const { return 0; }

  /// Preprocesses a BGR image of any size (empty unless needsImage()); `frame` is its name. Safe to call from
  /// several threads, also beside infer(). Throws Error when this image cannot be labeled.
  virtual Prepared prepare(const cv::Mat& bgr, const std::string& frame = "") const = 0;

  /// Turns a prepared image into probabilities; checked with requireProbabilities(). Not thread-safe.
  /// Throws FrameError when only this frame is at fault.
  virtual LexicalDescriptor infer(const Prepared& prepared) = 0;

  /// Several at once, in order; equal to one after the other, but quicker where the labeler can do it.
  virtual std::vector<LabelResult> inferBatch(std::span<const Prepared> batch);
  /// The batch size at which inferBatch() is fastest.
  virtual std::size_t batchSize() const { return 1; }

  /// The labels, by their numbers in vocabulary(), that labelRegions() can return; none unless it is a
  /// detector, or has one among its members.
  virtual std::vector<std::size_t> regionLabels() const { return {}; }
  /// How probably each region of a BGR image shows these labels, seen among what is around it: a descriptor a
  /// region, a value a label of regionLabels(), which need not add up to 1. Regions are parts of [0, 1] × [0,
  /// 1], the image's width and height. Not thread-safe. Throws FrameError as infer(), and Error
  /// (invalidInput) without such labels.
  virtual std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                                      std::span<const cv::Rect2d> regions);

  /// The labelers that this one puts together; empty when it is one by itself.
  virtual std::vector<Labeler*> members() { return {}; }
  /// The members' answers for one frame, in order, as one descriptor. For labelers with members.
  virtual LexicalDescriptor combine(std::span<const LexicalDescriptor> answers) const;

  LexicalDescriptor label(const cv::Mat& bgr, const std::string& frame = "") {
    return infer(prepare(bgr, frame));
  }
};

}  // namespace estancia
