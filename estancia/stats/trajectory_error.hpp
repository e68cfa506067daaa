// How far an estimated trajectory is from the true one.
#pragma once

#include <cstddef>
#include <span>

#include "estancia/core/pose.hpp"

namespace estancia {

/// Distances between positions after the best rigid alignment.
struct AbsoluteTrajectoryError {
  std::size_t poses = 0;
  double rmse = 0, mean = 0, median = 0, max = 0;  ///< [m]
  Pose truthFromEstimate;                          ///< the alignment: true ≈ truthFromEstimate · estimated
};

/// Moves the estimate onto the truth by the rotation and translation (no scale) that make the squared
/// distances of the positions least, and measures what is left (Umeyama 1991; Sturm et al. 2012). `estimated`
/// and `truth` are pairs of poses of the same moments. Throws Error when they are not equally many, none, or
/// not finite.
AbsoluteTrajectoryError absoluteTrajectoryError(std::span<const Pose> estimated, std::span<const Pose> truth);

/// Errors of the motion over `step` poses, whatever happened before: drift (Sturm et al. 2012).
struct RelativePoseError {
  std::size_t pairs = 0;
  double translationRmse = 0;  ///< [m]
  double rotationRmse = 0;     ///< [degrees]
};

/// Throws Error as absoluteTrajectoryError does, and when `step` is 0. No pairs when there are at most `step`
/// poses.
RelativePoseError relativePoseError(std::span<const Pose> estimated, std::span<const Pose> truth,
                                    std::size_t step = 1);

/// The way along the positions [m].
double pathLength(std::span<const Pose> poses);

}  // namespace estancia
