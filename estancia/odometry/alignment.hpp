// How one RGB-D image lies to another.
#pragma once

#include <opencv2/core/affine.hpp>

#include "estancia/odometry/open3d.hpp"

namespace estancia::odometry {

struct Alignment {
  bool solved = false;
  cv::Affine3d transform;  ///< T_target_source
  /// Share of the source's points that lie on the target's surface, as far as it is in view.
  double overlap = 0;
  double inView = 0;      ///< share of the source's points that fall into the target's image
  double rmse = 0;        ///< of their differences in depth [m]
  double likeness = 0;    ///< correlation of the gray values there; 1 where nothing is to be seen
  double firmness = 0;    ///< how well the planes in view fix the motion in its weakest direction [m²]
  Matrix6 information{};  ///< Σ GᵀG over those points: what they fix (Choi et al. 2015)
};

struct AlignmentOptions {
  AlignmentTerm term = AlignmentTerm::automatic;
  int mostSteps = 20;  ///< on the coarsest level; half as many on each finer one
  /// Twice on each coarser level: points that differ by more in depth are not taken for one while aligning
  /// [m].
  double beyond = 0.10;
  double sameSurface = 0.05;  ///< … and when the result is judged [m]
};

/// Coarse to fine, from `guess` (T_target_source).
Alignment align(const Pyramid& source, const Pyramid& target, const cv::Affine3d& guess,
                const AlignmentOptions& options);

Matrix4 matrixOf(const cv::Affine3d& transform);
cv::Affine3d rigidOf(const Matrix4& matrix);

}  // namespace estancia::odometry
