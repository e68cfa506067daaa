// RGB-D image alignment: the pose of an image among several others, and how well it is known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <span>

#include "estancia/odometry/pyramid.hpp"

namespace estancia::odometry {

/// Residuals that an alignment minimizes.
enum class AlignmentTerm {
  depth,     ///< point-to-plane distances; degenerate in front of a single wall
  color,     ///< differences of gray values; degenerate without texture
  hybrid,    ///< both, each as exact as its residuals are
  automatic  ///< both, gray values as if depth and color were registered only within pixels
};

/// An image whose pose is known.
struct AlignmentTarget {
  const Pyramid* pyramid;
  cv::Affine3d pose;  ///< T_map_target
};

struct Alignment {
  bool solved = false;
  cv::Affine3d transform;  ///< T_map_source
  // For the target that shows the largest part of the source:
  double overlap = 0;  ///< share of the source's points that lie on the target's surface
  /// root mean square difference in depth of the common points [m], scaled to 4 m at most
  double rmse = 0;
  double correlation = 0;  ///< correlation of their gray values; 1 without texture
  /// Share of the source's points that agree with any target in depth and in gray value.
  double agreement = 0;
  /// Information matrix of the residuals, for a motion (rotation, translation) that is multiplied from the
  /// left to T_target_source of the first target.
  cv::Matx66d information = cv::Matx66d::zeros();
  /// Standard deviation of the position in its least certain direction [m].
  double spread = 0;
};

struct AlignmentOptions {
  AlignmentTerm term = AlignmentTerm::automatic;
  std::size_t finest = 0;  ///< level of the pyramid on which it ends
};

/// Coarse to fine from `guess` (T_map_source), by Gauss–Newton steps on point-to-plane distances and gray
/// values, whose spreads are estimated and whose outliers are weighed down as under a t-distribution (Kerl et
/// al. 2013). Runs on the caller's thread alone.
Alignment align(const Pyramid& source, std::span<const AlignmentTarget> targets, const cv::Affine3d& guess,
                const AlignmentOptions& options);

/// The covariance that belongs to an information of align(), which takes neighboring pixels for independent
/// and the camera for perfect.
cv::Matx66d covarianceOf(const cv::Matx66d& information);

}  // namespace estancia::odometry
