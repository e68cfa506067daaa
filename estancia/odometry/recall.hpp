// Place recognition: earlier images with the most similar words.
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

/// Lexical descriptors of images, compared as in maps (standardized-clr, the best in measurements). Images
/// without words are never found.
class Recall {
 public:
  explicit Recall(const std::vector<LabelPart>& parts) : distance_(getDistance("standardized-clr", parts)) {}

  /// Images are numbered in this order. Throws Error (mismatch) when the number of labels changes.
  void add(const LexicalDescriptor& descriptor);

  std::size_t size() const { return embedded_.size(); }

  /// At most `max` eligible images, the nearest first. Standardized by the images so far.
  std::vector<std::size_t> nearest(const LexicalDescriptor& descriptor, std::size_t max,
                                   const std::function<bool(std::size_t)>& eligible) const;
  std::vector<std::size_t> nearest(std::size_t image, std::size_t max,
                                   const std::function<bool(std::size_t)>& eligible) const;

 private:
  std::vector<float> embed(const LexicalDescriptor& descriptor) const;
  std::vector<std::size_t> nearestEmbedded(const std::vector<float>& query, std::size_t max,
                                           const std::function<bool(std::size_t)>& eligible) const;

  Distance distance_;
  std::vector<std::vector<float>> embedded_;  ///< empty without words
  std::optional<Moments> moments_;            ///< of those that have words; absent while none has
};

}  // namespace estancia::odometry
