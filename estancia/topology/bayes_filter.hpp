// Bayes filter: a discrete filter over the frames of a map and the robot's direction of travel. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "estancia/topology/localizer.hpp"

namespace estancia {

/// States are (way of moving, image): the robot drives through the mapped images in their order, against it,
/// or stands. Driving moves on by 0, 1 or 2 images a frame, so other speeds than the mapping run's are
/// followed.
class PlaceFilter {
 public:
  /// `nodeOfImage`: each image's node as an index 0 … nodes−1. `edges`: linked nodes, both ways.
  PlaceFilter(std::vector<std::size_t> nodeOfImage, std::size_t nodes,
              const std::vector<std::pair<std::size_t, std::size_t>>& edges, PlaceFilterOptions options);

  std::size_t images() const { return nodeOf_.size(); }
  std::size_t states() const;

  /// Uniform over all states.
  std::vector<float> start() const;

  /// out(j) = Σ_i in(i) T(i, j): where the robot will be one frame later.
  void predict(std::span<const float> in, std::span<float> out) const;
  /// out(i) = Σ_j T(i, j) in(j): the same chances read backwards, for smoothing.
  void backward(std::span<const float> in, std::span<float> out) const;

  /// Evidence of one frame for each image, largest 1, from its distances to all images: exp(temper · standard
  /// score).
  std::vector<float> likelihood(std::span<const float> distances) const;
  /// Multiplies a state vector by the likelihood and scales the sum to 1.
  void observe(std::span<const float> likelihood, std::span<float> state) const;

  /// Sums the ways of moving: one probability an image.
  std::vector<float> marginal(std::span<const float> state) const;
  /// One probability a node.
  std::vector<float> nodeMarginal(std::span<const float> imageProbabilities) const;

 private:
  std::vector<std::size_t> nodeOf_;
  std::vector<std::vector<std::size_t>> imagesOf_;
  std::vector<std::vector<std::size_t>> linked_;
  PlaceFilterOptions options_;
};

}  // namespace estancia
