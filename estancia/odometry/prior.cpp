// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/prior.hpp"

#include <numbers>

#include "estancia/core/pose.hpp"

namespace estancia::odometry {

bool isTooFar(const cv::Affine3d& motion, std::size_t frames) {
  const auto steps = static_cast<double>(frames);
  return cv::norm(motion.translation()) > steps * 0.7 ||  // [m]
         angleOf(motion) > steps * 50 * std::numbers::pi / 180;
}

void PriorTrack::add(std::size_t frame, const std::optional<Pose>& pose, bool paused) {
  if (!pose || !pose->isPlausible()) return;
  Entry entry{*pose, 0};
  if (!entries_.empty()) {
    const Entry& before = *entries_.back();
    const cv::Affine3d step = rigidOf(before.pose).inv() * rigidOf(*pose);
    entry.run = before.run;
    if (!paused && isTooFar(step, frame + 1 - entries_.size())) ++entry.run;
  }
  restore(frame, entry);
}

const std::optional<PriorTrack::Entry>& PriorTrack::at(std::size_t frame) const {
  static const std::optional<Entry> unknown;
  return frame < entries_.size() ? entries_[frame] : unknown;
}

void PriorTrack::restore(std::size_t frame, const Entry& entry) {
  entries_.resize(frame + 1);
  entries_[frame] = entry;
}

std::optional<cv::Affine3d> PriorTrack::transform(std::size_t from, std::size_t to) const {
  const auto &a = at(from), &b = at(to);
  if (!a || !b || a->run != b->run) return std::nullopt;
  return rigidOf(a->pose).inv() * rigidOf(b->pose);
}

std::optional<Motion> PriorTrack::motion(std::size_t from, std::size_t to, const RgbdOptions& options) const {
  const auto whole = transform(from, to);
  if (!whole || from >= to) return std::nullopt;
  constexpr double minShift = 1e-3;  // [m] a step
  const double turn = options.odomTurn * std::numbers::pi / 180, share = options.odomShift / 100;
  cv::Matx66d covariance = cv::Matx66d::zeros();
  std::size_t last = from;
  for (std::size_t i = from + 1; i <= to; ++i) {
    if (!at(i)) continue;
    // A wrong turn at `last` swings what follows about it; it is written at `from`.
    const cv::Vec3d pivot = transform(from, last)->translation();
    const auto steps = static_cast<double>(i - last);
    const double shift = share * distanceBetween(at(last)->pose, at(i)->pose);
    const double entries[] = {1, 0,         0,        0,        1, 0,         0,         0,        1,
                              0, -pivot[2], pivot[1], pivot[2], 0, -pivot[0], -pivot[1], pivot[0], 0};
    const cv::Matx<double, 6, 3> turned(entries);
    covariance += steps * turn * turn * turned * turned.t();
    for (int a = 3; a < 6; ++a) covariance(a, a) += shift * shift + steps * minShift * minShift;
    last = i;
  }
  return Motion{*whole, covariance};
}

cv::Affine3d times(const cv::Affine3d& motion, double count) {
  return {count * motion.rvec(), count * motion.translation()};
}

std::optional<cv::Affine3d> bridged(std::size_t frame, const std::optional<TrackedFrame>& before,
                                    const std::optional<TrackedFrame>& after, const PriorTrack& prior) {
  const auto there = before ? prior.transform(before->frame, frame) : std::nullopt;
  const auto back = after ? prior.transform(frame, after->frame) : std::nullopt;
  std::optional<cv::Affine3d> fromOne;
  if (there)
    fromOne = before->pose * *there;
  else if (back)
    fromOne = after->pose * back->inv();
  if (!before || !after) return fromOne;
  const double part =
      static_cast<double>(frame - before->frame) / static_cast<double>(after->frame - before->frame);
  const cv::Affine3d whole = before->pose.inv() * after->pose;
  if (there && back) {
    const cv::Affine3d off = (*there * *back).inv() * whole;
    return before->pose * *there * times(off, part);
  }
  return isTooFar(whole) ? fromOne : before->pose * times(whole, part);
}

}  // namespace estancia::odometry
