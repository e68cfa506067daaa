// Bridging: poses of frames that could not be tracked, from those around them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <vector>

#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

/// T_map_frame of a frame without a pose: by the prior from the nearest frames that have one, which share
/// what it is off between them; without a prior by a steady motion, if they are no farther apart than two
/// frames may be (RgbdOptions::maxMotion, maxTurn). Nothing where neither can tell.
std::optional<cv::Affine3d> bridged(const std::vector<std::optional<cv::Affine3d>>& poses, std::size_t frame,
                                    const MotionPrior& prior, const RgbdOptions& options);

/// Whether a camera hardly moves so far from one frame to the next.
bool isTooFar(const cv::Affine3d& motion, const RgbdOptions& options);

/// A small motion, `count` times.
cv::Affine3d times(const cv::Affine3d& motion, double count);

}  // namespace estancia::odometry
