// A textured room that is rendered by arithmetic, and a camera that is driven through it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::test {

/// What a camera at `pose` sees of a room of 5 × 4 × 2.6 m around the origin.
struct RoomView {
  cv::Mat bgr;    ///< 8 bits
  cv::Mat depth;  ///< CV_32F [m], with a Kinect's noise when `noise` is 1
};
RoomView render(const Pose& pose, const CameraIntrinsics& camera, double noise, unsigned seed);

/// A drive as a sequence. Frames can be spoilt.
class Drive : public Sequence {
 public:
  explicit Drive(std::vector<Pose> path, double noise = 0);

  std::string name() const override { return "room"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override;
  bool hasDepth() const override { return depthKnown; }
  cv::Mat depth(std::size_t i) const override;

  void forgetCamera() { intrinsics_.reset(); }
  /// Only for those who look at no image then.
  void forgetPoses() {
    for (Frame& frame : frames_) frame.pose.reset();
  }
  void stamp(const std::vector<double>& seconds);

  bool depthKnown = true;
  double unit = 1;                      ///< depth is multiplied by it: other units
  int shrink = 1;                       ///< depth is so much smaller than the image
  int cutDepth = 0;                     ///< so many of its columns are missing
  std::set<std::size_t> noDepthFile;    ///< depth() throws
  std::set<std::size_t> noDepthValues;  ///< depth is 0 everywhere
  std::set<std::size_t> covered;        ///< a hand before the lens: gray, and 10 cm away

 private:
  std::vector<Frame> frames_;
  double noise_;
};

/// A level camera that turns once around on the spot, in so many frames, and goes on for as many as `again`.
std::vector<Pose> turnAround(int frames, int again = 0);

/// Words that depend on the direction of the camera, like a network's: alike for like views.
FrameWords wordsByHeading(const Sequence& sequence);

/// RMSE of the frames that have a pose [m].
double errorOf(const RgbdTrajectory& trajectory, const Sequence& sequence);

}  // namespace estancia::test
