// A made-up room seen by an RGB-D camera that is carried through it, and ways to spoil such a recording.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/sequences/trajectory.hpp"

namespace estancia::test {

/// Walls, floor, ceiling and some boxes, rendered by casting rays; z up, meters.
class RecordedRoom : public Sequence {
 public:
  explicit RecordedRoom(std::size_t size = 90) {
    intrinsics_ = CameraIntrinsics{160, 120, 140, 140, 79.5, 59.5};
    for (std::size_t i = 0; i < size; ++i) {
      const auto t = static_cast<double>(i);
      const Pose level = Pose::planar(1.2 * std::sin(0.13 * t), 0.9 * std::cos(0.09 * t), 0.4 + 0.05 * t);
      const cv::Affine3d tilt(cv::Vec3d(0.25 * std::sin(0.21 * t), 0, 0.15 * std::sin(0.17 * t)));
      cv::Affine3d camera = rigidOf(level) * tilt;
      camera.translation(camera.translation() + cv::Vec3d(0, 0, 0.3 * std::sin(0.11 * t)));
      frames_.push_back({"frame " + std::to_string(i), 10 + t / 30, poseOf(camera), ""});
    }
  }
  std::string name() const override { return "room"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  bool hasDepth() const override { return true; }

  cv::Mat depth(std::size_t i) const override {
    cv::Mat depth(intrinsics_->height, intrinsics_->width, CV_32F);
    const cv::Affine3d camera = rigidOf(*frames_[i].pose);
    depth.forEach<float>([&](float& d, const int* at) {
      // quantized like a sensor's
      d = std::round(1000 * static_cast<float>(hit(camera, at[1], at[0]))) / 1000;
    });
    return depth;
  }

  cv::Mat image(std::size_t i) const override {
    cv::Mat image(intrinsics_->height, intrinsics_->width, CV_8UC3);
    const cv::Affine3d camera = rigidOf(*frames_[i].pose);
    image.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* at) {
      const cv::Vec3d p = camera * (hit(camera, at[1], at[0]) * ray(at[1], at[0]));
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<uchar>(128 + 100 * std::sin((5 + c) * p[c]) * std::cos(7 * p[(c + 1) % 3]));
    });
    return image;
  }

 private:
  cv::Vec3d ray(int u, int v) const {
    return {(u - intrinsics_->cx) / intrinsics_->fx, (v - intrinsics_->cy) / intrinsics_->fy, 1};
  }

  /// Depth along the optical axis of what the pixel sees.
  double hit(const cv::Affine3d& camera, int u, int v) const {
    static const std::array<std::array<cv::Vec3d, 2>, 5> boxes = {{
        {cv::Vec3d(-4, -3, -1.2), cv::Vec3d(4, 3, 1.6)},  // the room itself, seen from inside
        {cv::Vec3d(2.2, -1, -1.2), cv::Vec3d(3, 0.5, -0.3)},
        {cv::Vec3d(-3.2, 1.8, -1.2), cv::Vec3d(-2.3, 2.6, 0.9)},
        {cv::Vec3d(0.5, 2.2, -1.2), cv::Vec3d(1.6, 3, 0.2)},
        {cv::Vec3d(-1.5, -2.8, -1.2), cv::Vec3d(-0.4, -2.1, 0.5)},
    }};
    const cv::Vec3d from = camera.translation(), along = camera.rotation() * ray(u, v);
    double nearest = 1e9;
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      double in = -1e9, out = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (boxes[b][0][axis] - from[axis]) / along[axis],
                     z = (boxes[b][1][axis] - from[axis]) / along[axis];
        in = std::max(in, std::min(a, z));
        out = std::min(out, std::max(a, z));
      }
      if (b == 0)
        nearest = out;
      else if (in < out && in > 0)
        nearest = std::min(nearest, in);
    }
    return nearest;
  }

  std::vector<Frame> frames_;
};

/// Another sequence with something changed.
class Altered : public Sequence {
 public:
  explicit Altered(const Sequence& sequence) : sequence_(sequence) {
    intrinsics_ = sequence.intrinsics();
    for (std::size_t i = 0; i < sequence.size(); ++i) frames.push_back(sequence.frame(i));
  }
  std::string name() const override { return sequence_.name(); }
  std::size_t size() const override { return frames.size(); }
  const Frame& frame(std::size_t i) const override { return frames[i]; }
  bool hasDepth() const override { return depthThere && sequence_.hasDepth(); }
  cv::Mat image(std::size_t i) const override {
    cv::Mat image = sequence_.image(i);
    if (alterImage) alterImage(i, image);
    return image;
  }
  cv::Mat depth(std::size_t i) const override {
    cv::Mat meters = sequence_.depth(i);
    if (alterDepth) alterDepth(i, meters);
    return meters;
  }
  std::optional<double> depthTimestamp(std::size_t i) const override {
    return depthDelay ? std::optional(*frames[i].timestamp + *depthDelay) : std::nullopt;
  }
  std::optional<CameraIntrinsics>& camera() { return intrinsics_; }
  std::optional<PoseSource>& source() { return poseSource_; }

  /// Changes every pose as a transform.
  void pose(const std::function<cv::Affine3d(cv::Affine3d)>& change) {
    for (Frame& frame : frames)
      if (frame.pose) frame.pose = poseOf(change(rigidOf(*frame.pose)));
  }

  /// Frame i gets the pose of frame i + by, at the ends the nearest.
  void shiftPoses(int by) {
    const std::vector<Frame> before = frames;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto from = static_cast<std::ptrdiff_t>(i) + by;
      const bool inside = from >= 0 && from < static_cast<std::ptrdiff_t>(before.size());
      frames[i].pose =
          before[static_cast<std::size_t>(inside ? from : (from < 0 ? 0 : before.size() - 1))].pose;
    }
  }

  std::vector<Frame> frames;
  bool depthThere = true;
  std::optional<double> depthDelay;  ///< [s] of depth behind color
  std::function<void(std::size_t, cv::Mat&)> alterImage, alterDepth;

 private:
  const Sequence& sequence_;
};

}  // namespace estancia::test
