// Which earlier images say the same words.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/stats/distance.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia::odometry {

/// Lexical descriptors of images, compared as maps compare them (standardized-clr: what measurement found
/// best). What has no words is never found and finds nothing.
class Recall {
 public:
  explicit Recall(const std::vector<LabelPart>& parts) : distance_(getDistance("standardized-clr", parts)) {}

  /// The number of the image is how many were added before it. Throws Error when the number of labels
  /// changes.
  void add(const LexicalDescriptor& descriptor);

  std::size_t size() const { return embedded_.size(); }

  /// At most `most` images that `eligible` admits, the nearest first. Standardized by the images so far.
  std::vector<std::size_t> nearest(const LexicalDescriptor& descriptor, std::size_t most,
                                   const std::function<bool(std::size_t)>& eligible) const;
  std::vector<std::size_t> nearest(std::size_t image, std::size_t most,
                                   const std::function<bool(std::size_t)>& eligible) const;

 private:
  std::vector<float> embed(const LexicalDescriptor& descriptor) const;
  std::vector<std::size_t> nearestEmbedded(const std::vector<float>& query, std::size_t most,
                                           const std::function<bool(std::size_t)>& eligible) const;

  Distance distance_;
  std::vector<std::vector<float>> embedded_;  ///< empty without words
  std::optional<Moments> moments_;            ///< of those that have words; absent while none has
};

}  // namespace estancia::odometry
