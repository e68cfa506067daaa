// Pose filter: a Bayes filter over the robot's pose on the floor, for maps whose frames have poses. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer.hpp"

namespace estancia {

/// Pose grid: a histogram over position and heading around a drive, which moves with the robot.
/// States are cells of the floor within `reach` of a mapped position, all of the first heading first.
class PoseGrid {
 public:
  static constexpr int headings = 24;

  /// The cells are `cell` meters wide, or wider, so that there are at most a million states.
  PoseGrid(std::span<const PlanarPose> mapped, double cell, double reach);

  std::size_t states() const { return cells() * headings; }
  std::size_t cells() const { return columns_.size(); }
  double cell() const { return cell_; }
  static double headingStep() { return 2 * std::numbers::pi / headings; }

  /// The middle of a state.
  PlanarPose poseOf(std::size_t state) const;
  /// Calls `use(state)` for the states within `distance` of a pose whose headings are within `angle` of it.
  void forStatesNear(const PlanarPose& pose, double distance, double angle,
                     const std::function<void(std::size_t)>& use) const;
  /// The state so many cells on; states() where there is none.
  std::size_t moved(std::size_t state, std::int64_t columns, std::int64_t rows) const;
  /// The state so many heading steps on.
  std::size_t turned(std::size_t state, std::int64_t steps) const;

  /// out(j) += Σ_i in(i) T(i, j): each state drives `motion`, spread over 8 states; what leaves is lost.
  void move(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const;
  /// out(i) += Σ_j T(i, j) in(j).
  void moveBackward(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const;
  /// Blurs by a Gaussian; symmetric. What leaves the grid is lost.
  void blur(std::vector<float>& values, double distance, double angle) const;

 private:
  template <typename Moves, typename Use>
  void forEachMove(const PlanarMotion& motion, const Moves& moves, const Use& use) const;
  bool layOut(std::span<const PlanarPose> mapped, double reach);
  /// -1 where there is none.
  std::int32_t cellAt(std::int64_t column, std::int64_t row) const;

  std::int64_t indexOf(double coordinate) const;
  double middleOf(std::int64_t index) const { return (static_cast<double>(index) + 0.5) * cell_; }

  double cell_;
  /// Indexed by column and row.
  std::unordered_map<std::int64_t, std::int32_t> cellOf_;
  std::vector<std::int32_t> columns_, rows_;
};

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
