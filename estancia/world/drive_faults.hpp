// Drive faults: what is wrong with the depth and the poses of a drive that is mapped. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estancia/core/frame.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/world/world_mapper.hpp"

namespace estancia {

/// Finds poses that jump, while they come. A camera has jumped when it moved twenty times as far as it mostly
/// does from frame to frame, and more than 1 m, faster than 5 m/s; without time stamps, more than 10 m. Where
/// it comes back, the frames between were elsewhere only by error.
///
/// Invariant: believed_ is the newest pose that can be believed, elsewhere_ the newest one after a jump away
/// from it, framesElsewhere_ the number of frames in a row there.
class PoseJumps {
 public:
  /// Returns whether the next frame's pose can be believed: after a jump, once three in a row were there.
  bool add(std::size_t number, const Frame& frame, const Pose& pose);

  /// The jump that add() has just found.
  const std::optional<PoseJump>& found() const { return found_; }

 private:
  struct Seen {
    std::size_t number = 0;
    std::string name;
    Pose pose;
    std::optional<double> time;
  };
  bool isJump(const Seen& from, const Seen& to) const;
  void step(const Seen& to);

  std::optional<Seen> believed_, elsewhere_;  // the latest of each
  std::size_t framesElsewhere_ = 0, steps_ = 0;
  double path_ = 0;  // length of all steps that are no jumps [m]
  std::optional<PoseJump> found_;
};

/// Counts the depth images without a value that can be used.
class DepthFaults {
 public:
  /// Checks the next frame's depth: CV_32F [m].
  void add(const Frame& frame, const cv::Mat& depth);
  const DriveFaults& faults() const { return faults_; }
  void add(const PoseJump& jump);
  void addDoubted() { ++faults_.doubted; }

 private:
  DriveFaults faults_;
};

}  // namespace estancia
