// RGB-D image alignment: relative pose of two images, and how reliable it is.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>

#include "estancia/odometry/open3d.hpp"

namespace estancia::odometry {

struct Alignment {
  bool solved = false;
  cv::Affine3d transform;  ///< T_target_source
  /// Share of the source's points that lie on the target's surface.
  double overlap = 0;
  double inView = 0;        ///< share of the source's points inside of the target's image
  double rmse = 0;          ///< of the differences in depth of the common points [m]
  double correlation = 0;   ///< of their gray values; 1 without texture
  double conditioning = 0;  ///< smallest eigenvalue of the point-to-plane Hessian: low when planes slide [m²]
  Matrix6 information{};    ///< Σ GᵀG over the common points (Choi et al. 2015)
};

struct AlignmentOptions {
  AlignmentTerm term = AlignmentTerm::automatic;
  int maxSteps = 20;  ///< on the coarsest level; half as many on each finer one
  /// Largest difference in depth of corresponding points while aligning [m]; doubled on each coarser level.
  double maxDifference = 0.10;
  double sameSurface = 0.05;  ///< the same when the result is evaluated [m]
};

/// Coarse to fine, from `guess` (T_target_source).
Alignment align(const Pyramid& source, const Pyramid& target, const cv::Affine3d& guess,
                const AlignmentOptions& options);

Matrix4 matrixOf(const cv::Affine3d& transform);
cv::Affine3d rigidOf(const Matrix4& matrix);

}  // namespace estancia::odometry
