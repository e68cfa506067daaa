// Trajectory error: absolute (ATE) and relative pose error (RPE) of an estimated trajectory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "estancia/core/pose.hpp"

namespace estancia {

/// Distances between positions after the best rigid alignment.
struct AbsoluteTrajectoryError {
  std::size_t poses = 0;
  /// [m]
  double rmse = 0, mean = 0, median = 0, max = 0;
  /// The alignment: true ≈ truthFromEstimate · estimated.
  Pose truthFromEstimate;
};

/// Aligns the estimate with the truth by the rotation and translation (no scale) of the least squared
/// distances of the positions, and measures the rest (Umeyama 1991; Sturm et al. 2012). Poses are pairs of
/// the same times. Throws Error (mismatch, invalidInput) when they are not equally many, none, or not finite.
AbsoluteTrajectoryError absoluteTrajectoryError(std::span<const Pose> estimated, std::span<const Pose> truth);

/// Error of the relative motion over `step` poses: drift (Sturm et al. 2012).
struct RelativePoseError {
  std::size_t pairs = 0;
  /// [m]
  double translationRmse = 0;
  /// [degrees]
  double rotationRmse = 0;
};

/// Throws Error as absoluteTrajectoryError(), and for a `step` of 0. No pairs of at most `step` poses.
RelativePoseError relativePoseError(std::span<const Pose> estimated, std::span<const Pose> truth,
                                    std::size_t step = 1);

/// Length of the path through the positions [m].
double pathLength(std::span<const Pose> poses);

}  // namespace estancia
