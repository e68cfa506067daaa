// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/bridge.hpp"

namespace estancia::odometry {

cv::Affine3d times(const cv::Affine3d& motion, double count) {
  return {count * motion.rvec(), count * motion.translation()};
}

std::optional<cv::Affine3d> bridged(std::size_t frame, const std::optional<TrackedFrame>& before,
                                    const std::optional<TrackedFrame>& after, const PriorTrack& prior) {
  const auto there = before ? prior.transform(before->frame, frame) : std::nullopt;
  const auto back = after ? prior.transform(frame, after->frame) : std::nullopt;
  if (!before || !after) {
    if (there) return before->pose * *there;
    if (back) return after->pose * back->inv();
    return std::nullopt;
  }
  const double part =
      static_cast<double>(frame - before->frame) / static_cast<double>(after->frame - before->frame);
  const cv::Affine3d whole = before->pose.inv() * after->pose;
  if (there && back) {
    const cv::Affine3d off = (*there * *back).inv() * whole;
    return before->pose * *there * times(off, part);
  }
  if (isTooFar(whole)) {
    if (there) return before->pose * *there;
    if (back) return after->pose * back->inv();
    return std::nullopt;
  }
  return before->pose * times(whole, part);
}

}  // namespace estancia::odometry
