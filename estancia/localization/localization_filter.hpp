// Localization filter: a Bayes filter whose states stand for where the robot may be in a map. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"

namespace estancia {

/// Belief of a filter; the sums may have any common scale.
struct Belief {
  /// One an image of the map: that the view is this one.
  std::vector<double> images;
  /// One an image of the map: that it is the nearest of all. Sums over nodes or zones are the answers.
  std::vector<double> nearest;
  /// Probability that no image of the map was taken nearby; absent where it cannot be computed.
  std::optional<double> unmapped = std::nullopt;
  /// Same probability for images in any direction.
  std::optional<double> unvisited = std::nullopt;
};

class LocalizationFilter {
 public:
  LocalizationFilter() = default;
  LocalizationFilter(const LocalizationFilter&) = delete;
  LocalizationFilter& operator=(const LocalizationFilter&) = delete;
  virtual ~LocalizationFilter() = default;

  virtual std::size_t states() const = 0;

  /// Possible motion since the last frame of a robot that does not report its motion.
  virtual PlanarMotion unknownMotion() const = 0;
  /// Whether the robot has moved enough for another view: frames in between add no information.
  virtual bool isStep(const PlanarMotion& motion) const = 0;

  /// out(j) = Σ_i in(i) T(i, j): where the robot will be after `motion`.
  virtual void predict(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const = 0;
  /// out(i) = Σ_j T(i, j) in(j): the same chances read backwards, for smoothing.
  virtual void backward(std::span<const float> in, const PlanarMotion& motion,
                        std::span<float> out) const = 0;

  /// Evidence of one frame for each image from its distances to all images, tempered.
  virtual std::vector<float> likelihood(std::span<const float> distances) const = 0;
  /// Multiplies a state vector by the likelihood of the images in each state, and scales the sum to 1.
  virtual void observe(std::span<const float> likelihood, std::span<float> state) const = 0;

  /// `likelihood` of the frame that the state belongs to.
  virtual Belief belief(std::span<const float> state, std::span<const float> likelihood) const = 0;

  /// Uniform over all states.
  std::vector<float> start() const {
    return std::vector<float>(states(), 1.0F / static_cast<float>(states()));
  }
};

/// A pose filter where half of the map's images have poses, else a place filter. `distance`: of two images.
std::unique_ptr<const LocalizationFilter> makeFilter(
    const LocalizerMap& source, const std::function<float(std::size_t, std::size_t)>& distance,
    const PlaceFilterOptions& options);

/// Place filter, over stored images in driving order, for maps without poses.
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
