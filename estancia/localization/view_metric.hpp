// View metric: how a map's images are compared, learned from images taken near each other. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {

/// The images around each image of a map, itself included, with weights whose sum is 1.
class Neighborhoods {
 public:
  struct Neighbor {
    std::uint32_t image;
    float weight;
  };
  /// How near images are: standard deviations of a Gaussian, [m] and [degrees].
  struct Reach {
    double distance, angle;
  };

  /// `images`: N×L unit vectors, in the order of the drive; `poses`: where they were taken, one each. Weights
  /// fall with the distance of two poses, where they are known for half of the images and images near each
  /// other look alike; else with the way through the images between the two.
  Neighborhoods(std::span<const float> images, std::span<const std::optional<Pose>> poses,
                const Reach& reach);

  std::size_t size() const { return first_.size() - 1; }
  std::span<const Neighbor> of(std::size_t image) const {
    return {neighbors_.data() + first_[image], neighbors_.data() + first_[image + 1]};
  }
  /// The weighted mean of the rows around an image.
  std::vector<float> mean(std::span<const float> images, std::size_t image) const;

 private:
  std::vector<std::size_t> first_{0};
  std::vector<Neighbor> neighbors_;
};

/// Within-class covariance normalization (Hatch, Kajarekar and Stolcke 2006): what differs between images
/// taken near each other carries little information about where they were taken. With Σ, the covariance of
/// images about the means of their neighborhoods, x becomes (I + Σ/σ²)^(−½) x, scaled to length 1. σ² is the
/// variance of Σ's directions that make up its variance, Σ v²/Σ v: what is not known of an image counts as
/// much as what is.
class ViewMetric {
 public:
  /// From about 500 of `images`, N×L unit vectors, evenly taken; without neighbors it changes nothing.
  ViewMetric(std::span<const float> images, const Neighborhoods& around);

  /// Rows of L values, in place.
  void apply(std::span<float> rows) const;

 private:
  std::size_t labels_;
  /// Orthogonal directions, R×L, and what is added along each: (1 + v/σ²)^(−½) − 1.
  std::vector<float> directions_, changes_;
};

}  // namespace estancia
