// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/drive_faults.hpp"

#include <cmath>
#include <utility>

#include "estancia/world_file/observation.hpp"

namespace estancia {
namespace {

constexpr double minJump = 1;          // [m]
constexpr double minUntimed = 10;      // [m]; without time stamps it may be the next room, much later
constexpr double timesTheUsual = 20;   // farther than from frame to frame
constexpr double fastest = 5;          // [m/s]
constexpr double usualAtFirst = 0.25;  // [m], for as many steps
constexpr double stepsAtFirst = 5;
constexpr std::size_t enoughFrames = 3;  // where the camera is believed to be after a jump
constexpr std::size_t maxNamed = 3;

}  // namespace

bool PoseJumps::isJump(const Seen& from, const Seen& to) const {
  const double way = distanceBetween(from.pose, to.pose);
  const double usual = (path_ + usualAtFirst * stepsAtFirst) / (static_cast<double>(steps_) + stepsAtFirst);
  if (!(way > minJump) || !(way > timesTheUsual * usual * static_cast<double>(to.number - from.number)))
    return false;
  if (!from.time || !to.time) return way > minUntimed;
  const double seconds = *to.time - *from.time;
  return seconds >= 0 && way > fastest * seconds;  // else another recording begins
}

void PoseJumps::step(const Seen& to) {
  path_ += distanceBetween(believed_->pose, to.pose);
  ++steps_;
}

bool PoseJumps::add(std::size_t number, const Frame& frame, const Pose& pose) {
  found_.reset();
  const std::optional<double>& time = frame.timestamp;
  const Seen now{number, frame.name, pose, time && std::isfinite(*time) ? time : std::nullopt};
  if (!believed_) {
    believed_ = now;
    return true;
  }
  const auto jumped = [&](const Seen& from) {
    PoseJump jump{from.name, frame.name, distanceBetween(from.pose, pose), std::nullopt};
    if (from.time && now.time) jump.seconds = *now.time - *from.time;
    return jump;
  };
  if (!isJump(*believed_, now)) {
    if (elsewhere_)
      found_ = jumped(*elsewhere_);  // back
    else
      step(now);
    elsewhere_.reset();
    believed_ = now;
    return true;
  }
  if (elsewhere_ && !isJump(*elsewhere_, now)) {
    elsewhere_ = now;
    if (++framesElsewhere_ < enoughFrames) return false;
    believed_ = std::exchange(elsewhere_, std::nullopt);
    return true;
  }
  found_ = jumped(elsewhere_ ? *elsewhere_ : *believed_);
  elsewhere_ = now;
  framesElsewhere_ = 1;
  return false;
}

void DepthFaults::add(const Frame& frame, const cv::Mat& depth) {
  ++faults_.depthImages;
  bool isFar = false;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (z > 0 && z < farthestDepth) return;
      isFar = isFar || z >= farthestDepth;
    }
  DriveFaults::Frames& kind = isFar ? faults_.tooFar : faults_.noDepth;
  if (kind.count++ == 0) kind.first = frame.name;
}

void DepthFaults::add(const PoseJump& jump) {
  ++faults_.jumps;
  if (faults_.named.size() < maxNamed) faults_.named.push_back(jump);
}

}  // namespace estancia
