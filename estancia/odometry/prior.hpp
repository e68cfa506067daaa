// Motion prior: the motion between frames by wheel odometry, its uncertainty, and poses that bridge gaps by
// it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <vector>

#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

struct Motion {
  cv::Affine3d transform;  ///< T_from_to
  cv::Matx66d covariance;  ///< covariance of a motion (rotation, translation) multiplied from the left
};

/// Whether a camera hardly moves so far in so many frames.
bool isTooFar(const cv::Affine3d& motion, std::size_t frames = 1);

/// The prior's poses, frame by frame. Where they jump farther than a camera moves, as when they were set
/// anew, nothing is known of the motion from before to after.
class PriorTrack {
 public:
  struct Entry {
    Pose pose;  ///< T_odom_camera
    /// Poses of one run belong together.
    std::uint32_t run = 0;
  };

  /// Adds the pose of frame number `frame`, which is later than the previous ones. Poses that are none (NaN)
  /// are not known. `paused`: much time has passed since the frame before, so that any motion is possible.
  void add(std::size_t frame, const std::optional<Pose>& pose, bool paused);
  /// Nothing where it is not known.
  const std::optional<Entry>& at(std::size_t frame) const;
  void restore(std::size_t frame, const Entry& entry);

  /// T_from_to; nothing where one of the two is not known.
  std::optional<cv::Affine3d> transform(std::size_t from, std::size_t to) const;
  /// Motion for from < to, and its accuracy: the errors of the frames between add up (RgbdOptions::odomShift
  /// and odomTurn).
  std::optional<Motion> motion(std::size_t from, std::size_t to, const RgbdOptions& options) const;

 private:
  std::vector<std::optional<Entry>> entries_;  ///< ends with the last frame that is known
};

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
