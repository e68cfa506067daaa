// Motion prior: what wheel odometry says of the motion between two frames, and how exact it is.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <optional>

#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

struct Motion {
  cv::Affine3d transform;  ///< T_from_to
  cv::Matx66d covariance;  ///< of a motion (rotation, translation) multiplied from the left
};

/// Nothing where the prior knows one of the two frames not. The errors of the frames between them add up
/// (RgbdOptions::odomShift and odomTurn).
std::optional<Motion> priorMotion(const MotionPrior& prior, std::size_t from, std::size_t to,
                                  const RgbdOptions& options);

}  // namespace estancia::odometry
