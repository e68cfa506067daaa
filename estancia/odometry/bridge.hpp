// Bridging: poses of frames that could not be tracked, from those around them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <optional>

#include "estancia/odometry/prior.hpp"

namespace estancia::odometry {

/// A frame that was tracked, and its T_map_frame.
struct TrackedFrame {
  std::size_t frame;
  cv::Affine3d pose;
};

/// T_map_frame of a frame between two that were tracked, of which one may be missing: by the prior, and what
/// it is off is shared between them; without a prior by a steady motion, if they are no farther apart than
/// two frames may be (isTooFar()). Nothing if neither applies.
std::optional<cv::Affine3d> bridged(std::size_t frame, const std::optional<TrackedFrame>& before,
                                    const std::optional<TrackedFrame>& after, const PriorTrack& prior);

/// A small motion, `count` times.
cv::Affine3d times(const cv::Affine3d& motion, double count);

}  // namespace estancia::odometry
