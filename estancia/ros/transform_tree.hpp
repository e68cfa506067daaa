// Transform tree: where frames are in each other, over time, as tf2 keeps it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/ros/messages.hpp"

namespace estancia::ros {

/// Frames and their parents. A frame has one parent at a time; transforms are rigid.
class TransformTree {
 public:
  /// Where a moving transform is not known at a time, it is interpolated between two at most `maxBetween`
  /// [ns] apart, else taken from one that is at most `maxAway` [ns] from it.
  TransformTree(std::int64_t maxBetween, std::int64_t maxAway) : maxBetween_(maxBetween), maxAway_(maxAway) {}
  /// `maxAway` is `maxGap` [s], `maxBetween` ten times that: motion between two is known from both sides.
  explicit TransformTree(double maxGap);

  /// T_parent_child, in any order of time; static ones hold always. Returns whether it was taken: numbers
  /// that are not finite, a quaternion of no length, and a frame that is its own parent are not.
  bool add(const StampedPose& transform, bool isStatic);
  /// T_target_source at a time [ns]; nothing where they are not joined, or a transform is not known then.
  std::optional<cv::Affine3d> find(const std::string& target, const std::string& source,
                                   std::int64_t time) const;
  /// Forgets moving transforms before a time [ns], but for the last of each: a live tree stays small.
  void forgetBefore(std::int64_t time);
  /// The frame above all that `frame` hangs on; itself where it hangs on none.
  std::string rootOf(const std::string& frame) const;
  /// Whether a moving transform is between the frame and its root.
  bool isMoving(const std::string& frame) const;
  bool has(const std::string& frame) const { return links_.contains(frame); }
  bool empty() const { return links_.empty(); }

 private:
  struct Link {
    std::string parent;
    bool isStatic = false;
    /// By time; one of a static link.
    std::map<std::int64_t, Pose> poses;
  };
  std::optional<cv::Affine3d> at(const Link& link, std::int64_t time) const;
  /// The frame and those above it.
  std::vector<std::string> pathUp(const std::string& frame) const;

  std::map<std::string, Link> links_;
  std::int64_t maxBetween_, maxAway_;
};

/// A body's axes (x forward, y left, z up; REP-103) ← those of a camera that looks ahead: the default.
inline const cv::Affine3d bodyFromCameraAhead(cv::Matx33d(0, 0, 1, -1, 0, 0, 0, -1, 0), cv::Vec3d(0, 0, 0));

/// The pose between two at a share of the way from 0 to 1; rotations by slerp (Shoemake 1985).
Pose interpolated(const Pose& from, const Pose& to, double share);

/// With a quaternion of unit length; nothing where its numbers are not finite, or it has no length.
std::optional<Pose> normalized(const Pose& pose);

}  // namespace estancia::ros
