// How far a found pose is from the true one.
#pragma once

#include <opencv2/core/affine.hpp>
#include <span>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

struct PoseError {
  double translation = 0;  ///< of the model's center [m]
  double rotation = 0;     ///< [degrees], 0 … 180
};

/// The middle of the box around a cloud's finite points [m]: what stays in place when a symmetric object
/// turns. Throws Error on a cloud without any.
cv::Point3d centerOf(const PointCloud& model);

/// Between two T_scene_model of a model whose center lies at `center`. A symmetric object looks the same
/// after each of `symmetries` (T_model_model, without the identity): the one that gives the least rotation
/// counts.
PoseError poseError(const cv::Affine3d& found, const cv::Affine3d& truth, const cv::Point3d& center,
                    std::span<const cv::Affine3d> symmetries = {});

/// The turns by 360°/`fold`, and their multiples, around the axis through `center`: symmetries of a pyramid
/// (4) or, when fine enough, of a bottle (360).
std::vector<cv::Affine3d> turnsAround(const cv::Point3d& center, const cv::Vec3d& axis, int fold);

/// The honest score: at most 0.02 m and 15° off.
bool isCorrect(const PoseError& error, double translation = 0.02, double rotation = 15);

}  // namespace estancia
