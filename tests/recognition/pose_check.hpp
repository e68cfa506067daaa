// Pose check: translation and rotation between a found and the true pose.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core/affine.hpp>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::test {

struct PoseError {
  /// Distance between the model's centers [m].
  double translation = 0;
  /// [degrees], 0 … 180
  double rotation = 0;
};

/// The center of the bounding box of a cloud's finite points [m].
inline cv::Point3d centerOf(const PointCloud& model) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  cv::Point3f low(infinity, infinity, infinity), high = -low;
  for (const cv::Point3f& p : model.points) {
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return (cv::Point3d(low) + cv::Point3d(high)) / 2;
}

/// Between two T_scene_model of a model with this center.
inline PoseError poseError(const cv::Affine3d& found, const cv::Affine3d& truth, const cv::Point3d& center) {
  return {cv::norm(found * center - truth * center), angleOf(found.inv() * truth) * 180 / std::numbers::pi};
}

/// Whether the error is at most 0.02 m and 15°.
inline bool isCorrect(const PoseError& error) {
  return error.translation <= 0.02 && error.rotation <= 15;
}

}  // namespace estancia::test
