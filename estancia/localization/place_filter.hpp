// Place filter: a Bayes filter over stored images in driving order, for maps without poses. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer.hpp"

namespace estancia {

/// States are (way of moving, image): the robot drives through the mapped images in their order, against it,
/// or stands. Driving moves on by 0, 1 or 2 images a frame, to follow other speeds than the mapping run's.
class PlaceFilter : public LocalizationFilter {
 public:
  /// `nodeOfImage`: each image's node as an index 0 … nodes−1. `edges`: linked nodes, both ways.
  PlaceFilter(std::vector<std::size_t> nodeOfImage, std::size_t nodes,
              const std::vector<std::pair<std::size_t, std::size_t>>& edges, PlaceFilterOptions options);

  std::size_t images() const { return nodeOf_.size(); }
  std::size_t states() const override;

  /// Motion is counted in images of the map, not in meters.
  PlanarMotion unknownMotion() const override { return {}; }
  bool isStep(const PlanarMotion&) const override { return true; }
  void predict(std::span<const float> in, const PlanarMotion&, std::span<float> out) const override;
  void backward(std::span<const float> in, const PlanarMotion&, std::span<float> out) const override;

  /// Largest 1: exp(temper · standard score).
  std::vector<float> likelihood(std::span<const float> distances) const override;
  void observe(std::span<const float> likelihood, std::span<float> state) const override;
  /// Sums the ways of moving.
  Belief belief(std::span<const float> state, std::span<const float>) const override;

 private:
  std::vector<std::size_t> nodeOf_;
  std::vector<std::vector<std::size_t>> imagesOf_;
  std::vector<std::vector<std::size_t>> linked_;
  PlaceFilterOptions options_;
};

}  // namespace estancia
