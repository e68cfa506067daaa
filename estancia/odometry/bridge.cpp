// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/bridge.hpp"

#include <numbers>

#include "estancia/core/rigid.hpp"
#include "estancia/odometry/prior.hpp"

namespace estancia::odometry {

cv::Affine3d times(const cv::Affine3d& motion, double count) {
  return {count * motion.rvec(), count * motion.translation()};
}

bool isTooFar(const cv::Affine3d& motion, const RgbdOptions& options) {
  return cv::norm(motion.translation()) > options.maxMotion ||
         angleOf(motion) > options.maxTurn * std::numbers::pi / 180;
}

std::optional<cv::Affine3d> bridged(const std::vector<std::optional<cv::Affine3d>>& poses, std::size_t frame,
                                    const MotionPrior& prior, const RgbdOptions& options) {
  std::size_t before = frame, after = frame;
  while (before < poses.size() && !poses[before]) --before;  // beyond 0 it wraps around, and ends
  while (after < poses.size() && !poses[after]) ++after;
  const bool begins = before < poses.size(), ends = after < poses.size();
  const auto there = begins ? priorMotion(prior, before, frame, options) : std::nullopt;
  const auto back = ends ? priorMotion(prior, frame, after, options) : std::nullopt;
  if (!begins || !ends) {
    if (there) return *poses[before] * there->transform;
    if (back) return *poses[after] * back->transform.inv();
    return std::nullopt;
  }
  const double part = static_cast<double>(frame - before) / static_cast<double>(after - before);
  const cv::Affine3d whole = poses[before]->inv() * *poses[after];
  if (there && back) {
    const cv::Affine3d off = (there->transform * back->transform).inv() * whole;
    return *poses[before] * there->transform * times(off, part);
  }
  if (isTooFar(whole, options)) return std::nullopt;
  return *poses[before] * times(whole, part);
}

}  // namespace estancia::odometry
