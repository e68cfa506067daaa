// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/transform_tree.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "estancia/core/pose.hpp"

namespace estancia::ros {
namespace {

/// A chain of frames is short; a longer one goes in circles.
constexpr std::size_t maxFramesInChain = 100;
constexpr double interpolatedPerHeld = 10;

std::int64_t nanosecondsOf(double seconds) {
  return static_cast<std::int64_t>(std::min(seconds, 1e9) * 1e9);
}

}  // namespace

TransformTree::TransformTree(double maxGap)
    : TransformTree(nanosecondsOf(maxGap * interpolatedPerHeld), nanosecondsOf(maxGap)) {}

std::optional<Pose> normalized(const Pose& pose) {
  const double length =
      std::sqrt(pose.qx * pose.qx + pose.qy * pose.qy + pose.qz * pose.qz + pose.qw * pose.qw);
  // Single-precision quaternions are off by 1e-7; one that is off by a tenth is none.
  if (!pose.isPlausible() || !(length > 0.9 && length < 1.1)) return std::nullopt;
  Pose unit = pose;
  for (double* q : {&unit.qx, &unit.qy, &unit.qz, &unit.qw}) *q /= length;
  return unit;
}

Pose interpolated(const Pose& from, const Pose& to, double share) {
  const double cosine = from.qx * to.qx + from.qy * to.qy + from.qz * to.qz + from.qw * to.qw;
  const double sign = cosine < 0 ? -1 : 1;  // q and −q are one rotation
  const double angle = std::acos(std::min(std::abs(cosine), 1.0));
  const bool isSmall = angle < 1e-6;
  const double a = isSmall ? 1 - share : std::sin((1 - share) * angle) / std::sin(angle);
  const double b = sign * (isSmall ? share : std::sin(share * angle) / std::sin(angle));
  const Pose between{from.x + share * (to.x - from.x), from.y + share * (to.y - from.y),
                     from.z + share * (to.z - from.z), a * from.qx + b * to.qx,
                     a * from.qy + b * to.qy,          a * from.qz + b * to.qz,
                     a * from.qw + b * to.qw};
  return normalized(between).value_or(from);
}

bool TransformTree::add(const StampedPose& transform, bool isStatic) {
  const auto pose = normalized(transform.pose);
  if (!pose || transform.child.empty() || transform.child == transform.header.frame) return false;
  Link& link = links_[transform.child];
  if (link.parent != transform.header.frame || link.isStatic != isStatic || isStatic)
    link = {transform.header.frame, isStatic, {}};
  link.poses.insert_or_assign(transform.header.stamp, *pose);
  return true;
}

std::optional<cv::Affine3d> TransformTree::at(const Link& link, std::int64_t time) const {
  if (link.isStatic) return rigidOf(link.poses.begin()->second);
  const auto next = link.poses.lower_bound(time);
  const auto last = next == link.poses.begin() ? link.poses.end() : std::prev(next);
  if (next != link.poses.end() && last != link.poses.end() && next->first - last->first <= maxBetween_)
    return rigidOf(interpolated(
        last->second, next->second,
        static_cast<double>(time - last->first) / static_cast<double>(next->first - last->first)));
  const auto isNear = [&](auto sample) {
    return sample != link.poses.end() && std::abs(sample->first - time) <= maxAway_;
  };
  if (isNear(last) && (!isNear(next) || time - last->first < next->first - time))
    return rigidOf(last->second);
  return isNear(next) ? std::optional(rigidOf(next->second)) : std::nullopt;
}

void TransformTree::forgetBefore(std::int64_t time) {
  for (auto& [child, link] : links_)
    if (!link.isStatic)
      while (link.poses.size() > 1 && link.poses.begin()->first < time) link.poses.erase(link.poses.begin());
}

std::vector<std::string> TransformTree::pathUp(const std::string& frame) const {
  std::vector<std::string> path{frame};
  for (auto link = links_.find(frame); link != links_.end() && path.size() < maxFramesInChain;
       link = links_.find(path.back()))
    path.push_back(link->second.parent);
  return path;
}

std::string TransformTree::rootOf(const std::string& frame) const {
  return pathUp(frame).back();
}

bool TransformTree::isMoving(const std::string& frame) const {
  return std::ranges::any_of(pathUp(frame), [this](const std::string& on) {
    const auto link = links_.find(on);
    return link != links_.end() && !link->second.isStatic;
  });
}

std::optional<cv::Affine3d> TransformTree::find(const std::string& target, const std::string& source,
                                                std::int64_t time) const {
  const std::vector<std::string> up = pathUp(source), down = pathUp(target);
  const auto common = std::ranges::find_first_of(up, down);
  if (common == up.end()) return std::nullopt;
  const auto product = [&](const std::vector<std::string>& path) -> std::optional<cv::Affine3d> {
    cv::Affine3d transform = cv::Affine3d::Identity();
    for (auto frame = path.begin(); frame != path.end() && *frame != *common; ++frame) {
      const auto step = at(links_.at(*frame), time);
      if (!step) return std::nullopt;
      transform = *step * transform;
    }
    return transform;
  };
  const auto commonFromSource = product(up), commonFromTarget = product(down);
  if (!commonFromSource || !commonFromTarget) return std::nullopt;
  return commonFromTarget->inv() * *commonFromSource;
}

}  // namespace estancia::ros
