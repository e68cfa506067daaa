// Pose grid: a histogram over position and heading around a drive, which moves with the robot. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {

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

}  // namespace estancia
