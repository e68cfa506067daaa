// Pose error: translation and rotation between a found and the true pose, symmetries considered.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <span>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia::experiments {

struct PoseError {
  /// Distance between the model's centers [m].
  double translation = 0;
  /// [degrees], 0 … 180
  double rotation = 0;
};

/// The center of the bounding box of a cloud's finite points [m]: it stays in place when a symmetric object
/// rotates. Throws Error (invalidInput) on a cloud without any.
cv::Point3d centerOf(const PointCloud& model);

/// Between two T_scene_model of a model with this center. A symmetric object looks the same after each of
/// `symmetries` (T_model_model, without the identity); the one with the smallest rotation counts.
PoseError poseError(const cv::Affine3d& found, const cv::Affine3d& truth, const cv::Point3d& center,
                    std::span<const cv::Affine3d> symmetries = {});

/// The rotations by multiples of 360°/`fold` around the axis through `center`: symmetries of a pyramid (4) or
/// nearly of a bottle (360). Throws Error (invalidOption).
std::vector<cv::Affine3d> turnsAround(const cv::Point3d& center, const cv::Vec3d& axis, int fold);

/// Whether the error is at most 0.02 m and 15°.
bool isCorrect(const PoseError& error, double translation = 0.02, double rotation = 15);

}  // namespace estancia::experiments
