// Place recognition: earlier images with the most similar words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia::odometry {

/// Lexical descriptors of images, compared as in maps (standardized-clr, the best in measurements). Images
/// without words are never found.
class Recall {
 public:
  explicit Recall(const std::vector<LabelPart>& parts) : distance_(getDistance("standardized-clr", parts)) {}

  /// Images are numbered in this order; takes what embed() returns. Throws Error (mismatch) when the number
  /// of labels changes.
  void add(std::vector<float> embedded);
  void removeLast();

  /// A descriptor as it is compared, and that of an image; empty without words.
  std::vector<float> embed(const LexicalDescriptor& descriptor) const;
  const std::vector<float>& embedded(std::size_t image) const { return embedded_[image]; }

  /// At most `max` eligible images, the nearest to embed() of a descriptor first. Standardized by the images
  /// so far.
  std::vector<std::size_t> nearest(const std::vector<float>& query, std::size_t max,
                                   const std::function<bool(std::size_t)>& eligible) const;

 private:
  Distance distance_;
  std::vector<std::vector<float>> embedded_;
  std::optional<Moments> moments_;  ///< moments of the keyframes with words; absent while none has
};

}  // namespace estancia::odometry
