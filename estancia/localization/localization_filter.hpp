// Localization filter: a Bayes filter whose states stand for where the robot may be in a map. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
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

}  // namespace estancia
