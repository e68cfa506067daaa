// Image → words: the one interface of everything that labels.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Anything that gives an image's labels with probabilities (thesis 1.6): a CNN, several, a service, a
/// person. Labelling has two steps so that a stream can prepare the next image while this one is inferred.
class Labeler {
 public:
  virtual ~Labeler() = default;

  virtual const Vocabulary& vocabulary() const = 0;

  /// Identifies the model for caches and maps: name and digest of its files.
  virtual std::string identity() const = 0;

  /// Preprocesses a BGR image of any size. Safe to call from another thread than infer().
  virtual cv::Mat prepare(const cv::Mat& bgr) const = 0;

  /// Turns a prepared image into probabilities; checked with requireProbabilities(). Not thread-safe.
  virtual LexicalDescriptor infer(const cv::Mat& prepared) = 0;

  LexicalDescriptor label(const cv::Mat& bgr) { return infer(prepare(bgr)); }
};

}  // namespace estancia
