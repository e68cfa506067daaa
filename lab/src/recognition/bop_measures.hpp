// BOP measures: VSD, MSSD, MSPD and recall of estimated poses, as the BOP challenge has them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "recognition/bop_data.hpp"

namespace estancia::experiments {

/// Depth of a mesh in a pose (T_camera_model), CV_32F [m]; 0 where it is not. Triangles that are not wholly
/// in front of the camera are left out.
cv::Mat renderMesh(const PlyMesh& mesh, const cv::Affine3d& pose, const CameraIntrinsics& camera);

/// Depth images of the same camera [m].
struct VisibleSurfaces {
  cv::Mat measured, truth, found;
};
/// Visible surface discrepancy, 0 … 1 (Hodaň et al., ECCV 2018, with the step function), for misalignments of
/// 5 %, 10 %, … 50 % of the diameter [m]. Pixels that were not measured show what would be there.
std::array<double, 10> visibleSurfaceDiscrepancy(const VisibleSurfaces& depths,
                                                 const CameraIntrinsics& camera, double delta,
                                                 double diameter);

/// Maximum symmetry-aware surface distance of the vertices [m] (Drost et al., ICCV workshops 2017).
double maxSurfaceDistance(const BopObject& object, const cv::Affine3d& found, const cv::Affine3d& truth);

/// Maximum symmetry-aware projection distance of the vertices [pixels]; infinite for what is not wholly in
/// front of the camera.
double maxProjectionDistance(const BopObject& object, const cv::Affine3d& found, const cv::Affine3d& truth,
                             const CameraIntrinsics& camera);

/// How many estimates are right: best first, each takes the instance with its smallest error below
/// `threshold` that none before it has taken. `errors[estimate][instance]`.
std::size_t matchEstimates(const std::vector<std::vector<double>>& errors, double threshold);

/// Instances to be found, and those that were: means over the measure's thresholds.
struct BopScore {
  double targets = 0, vsd = 0, mssd = 0, mspd = 0;

  BopScore& operator+=(const BopScore& other);
  /// The mean of the three average recalls.
  double recall() const { return targets > 0 ? (vsd + mssd + mspd) / 3 / targets : 0; }
};

/// Judges the estimates of a target, best first, by as many of its most visible instances.
BopScore judgeEstimates(const BopTarget& target, const BopObject& object,
                        std::span<const cv::Affine3d> estimates, const BopImage& image,
                        const DepthFrame& frame, double delta);

}  // namespace estancia::experiments
