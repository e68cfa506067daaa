// Pose filter: a Bayes filter over the robot's pose on the floor, for maps whose frames have poses. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/pose_grid.hpp"

namespace estancia {

/// The likelihood ratio p(distance | near) / p(distance | far) of two Gaussians, made to fall with distance.
class NearEvidence {
 public:
  /// Distances of pairs of frames of a map that were taken near each other, and of any others; neither empty.
  NearEvidence(const std::vector<float>& near, const std::vector<float>& far);

  double ratio(double distance) const;

 private:
  static constexpr std::size_t samples = 64;
  double first_, step_;
  /// Logarithms of the ratio.
  std::vector<double> log_;
};

/// States are poses around the mapped drive. An image is evidence for the poses near its own; poses near no
/// image are neither confirmed nor refuted by anything, so the robot is followed by its motion where nothing
/// was mapped.
///
/// Immutable: the constructor computes the images near each state once; belief vectors are the caller's.
class PoseFilter : public LocalizationFilter {
 public:
  /// `images`: where those that localization compares with were taken, as far as known.
  PoseFilter(std::vector<std::optional<PlanarPose>> images, NearEvidence evidence,
             const PlaceFilterOptions& options);

  std::size_t states() const override { return grid_.states(); }
  PlanarMotion unknownMotion() const override { return unknown_; }
  bool isStep(const PlanarMotion& motion) const override;
  void predict(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const override;
  void backward(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const override;
  std::vector<float> likelihood(std::span<const float> distances) const override;
  void observe(std::span<const float> likelihood, std::span<float> state) const override;
  Belief belief(std::span<const float> state, std::span<const float> likelihood) const override;

 private:
  struct Near {
    std::uint32_t image;
    float weight;
  };
  std::span<const Near> nearOf(std::size_t state) const;
  void findNearImages();
  void findNearestImages();
  void findUnvisited();

  std::vector<std::optional<PlanarPose>> images_;
  NearEvidence evidence_;
  PlaceFilterOptions options_;
  PoseGrid grid_;
  PlanarMotion unknown_;
  /// Images near each state: near_[firstNear_[s]] … near_[firstNear_[s + 1] − 1].
  std::vector<std::size_t> firstNear_;
  std::vector<Near> near_;
  /// The image nearest to each state, however far.
  std::vector<std::uint32_t> nearest_;
  /// Whether that one is far from the state, by position alone.
  std::vector<bool> isUnvisited_;
};

}  // namespace estancia
