// SPDX-License-Identifier: Apache-2.0
#include "recognition/pose_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::experiments {

cv::Point3d centerOf(const PointCloud& model) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  cv::Point3f low(infinity, infinity, infinity), high = -low;
  for (const cv::Point3f& p : model.points) {
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  if (low.x > high.x)
    fail(ErrorCode::invalidInput, "none of the model's {} points is finite, so it has no center",
         model.points.size());
  return (cv::Point3d(low) + cv::Point3d(high)) / 2;
}

PoseError poseError(const cv::Affine3d& found, const cv::Affine3d& truth, const cv::Point3d& center,
                    std::span<const cv::Affine3d> symmetries) {
  const auto between = [&](const cv::Affine3d& same) {
    return PoseError{cv::norm(found * center - same * center),
                     angleOf(found.inv() * same) * 180 / std::numbers::pi};
  };
  PoseError smallest = between(truth);
  for (const cv::Affine3d& symmetry : symmetries)
    if (const PoseError error = between(truth * symmetry); error.rotation < smallest.rotation)
      smallest = error;
  return smallest;
}

std::vector<cv::Affine3d> turnsAround(const cv::Point3d& center, const cv::Vec3d& axis, int fold) {
  const double length = cv::norm(axis);
  if (fold < 2 || !(length > 0) || !std::isfinite(length))
    fail(ErrorCode::invalidOption, "the fold of a symmetry is {}; give 2 or more, and an axis that is not 0",
         fold);
  std::vector<cv::Affine3d> turns;
  for (int k = 1; k < fold; ++k) {
    const cv::Affine3d turn(axis * (2 * std::numbers::pi * k / fold / length));
    turns.push_back(turn.translate(cv::Vec3d(center - turn * center)));
  }
  return turns;
}

bool isCorrect(const PoseError& error, double translation, double rotation) {
  return error.translation <= translation && error.rotation <= rotation;
}

}  // namespace estancia::experiments
