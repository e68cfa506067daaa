// Drive alignment: where the frame of a drive's poses is in the map, from recognized views. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {

/// A frame was taken near a view of the map, by words: its pose in the drive's own frame is about that view's
/// in the map. Some of these are wrong. The alignment is the rigid transform that most of them agree with.
class DriveAlignment {
 public:
  /// Views this far apart [m], whose directions differ by this [degrees], can be taken for one.
  DriveAlignment(double nearDistance, double nearAngle);

  /// Returns whether the frame was added: those from a position in the sum already add no information.
  bool add(const Pose& own, const Pose& inMap);

  struct Estimate {
    cv::Affine3d transform;  ///< T_map_drive
    std::size_t agreeing = 0;
    /// How far apart the agreeing frames were taken, at most [m].
    double extent = 0;

    /// Whether words alone are enough to believe it: eight frames agree, taken 4 m apart.
    bool isCertain() const;
  };
  /// The least-squares transform of most pairs; nothing where fewer than half of them, or than five, agree.
  std::optional<Estimate> estimate() const;
  /// All that add() took.
  std::size_t pairs() const { return taken_; }

  /// To go on later. `next`: a number kept with it that restore() returns. Throws Error (corruptFile).
  std::string state(std::size_t next) const;
  std::size_t restore(const std::string& state);

 private:
  struct Pair {
    cv::Affine3d own, inMap;
  };
  bool agrees(const cv::Affine3d& transform, const Pair& pair) const;
  cv::Affine3d fit(const std::vector<const Pair*>& pairs) const;

  double nearDistance_, nearAngle_;
  std::vector<Pair> pairs_;  ///< the latest
  std::size_t taken_ = 0;
};

}  // namespace estancia
