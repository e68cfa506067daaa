// SPDX-License-Identifier: Apache-2.0
#include "support/room.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/stats/trajectory_error.hpp"

namespace estancia::test {
namespace {

/// 0 to 1, the same for the same cell of the same wall.
double cellValue(std::int64_t x, std::int64_t y, int wall) {
  auto h =
      static_cast<std::uint64_t>(x * 73856093 ^ y * 19349663 ^
                                 static_cast<std::int32_t>(static_cast<std::uint32_t>(wall + 7) * 83492791U));
  h = (h ^ (h >> 31)) * 0x9E3779B97F4A7C15ULL;
  return static_cast<double>((h >> 33) % 1024) / 1023;
}

/// Tiles of 20 cm with smaller ones upon them: corners at every distance.
double texture(double u, double v, int wall) {
  double value = 0;
  for (const auto& [size, share] : {std::pair{0.35, 0.6}, std::pair{0.09, 0.4}})
    value += share * cellValue(static_cast<std::int64_t>(std::floor(u / size)),
                               static_cast<std::int64_t>(std::floor(v / size)), wall);
  return value;
}

struct Hit {
  double distance = 1e9;
  double value = 0;
};

void meet(Hit& hit, const cv::Vec3d& from, const cv::Vec3d& ray, const cv::Vec3d& low, const cv::Vec3d& high,
          bool fromInside, int first) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      if (std::abs(ray[axis]) < 1e-12) continue;
      const double s = ((upper ? high[axis] : low[axis]) - from[axis]) / ray[axis];
      if (s < 0.05 || s >= hit.distance) continue;
      if (!fromInside && (ray[axis] > 0) == upper) continue;  // the far side of a box
      const cv::Vec3d at = from + s * ray;
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      if (at[a] < low[a] || at[a] > high[a] || at[b] < low[b] || at[b] > high[b]) continue;
      const int wall = first + 2 * axis + (upper ? 1 : 0);
      hit = {s, texture(at[a], at[b], wall)};
    }
}

CameraIntrinsics smallCamera() {
  return {160, 120, 140, 140, 79.5, 59.5};
}

}  // namespace

RoomView render(const Pose& pose, const CameraIntrinsics& camera, double noise, unsigned seed) {
  const cv::Affine3d mapFromCamera = rigidOf(pose);
  const cv::Vec3d from = mapFromCamera.translation();
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  RoomView view{cv::Mat(camera.height, camera.width, CV_8UC3), cv::Mat(camera.height, camera.width, CV_32F)};
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const cv::Vec3d ray =
          mapFromCamera.rotation() * cv::Vec3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      Hit hit;
      meet(hit, from, ray, {-2.5, -2, -1.2}, {2.5, 2, 1.4}, true, 0);
      // Furniture, so that every view fixes all six degrees of freedom.
      meet(hit, from, ray, {1.6, -0.4, -1.2}, {2.2, 0.3, 0.1}, false, 10);
      meet(hit, from, ray, {-0.6, 1.3, -1.2}, {0.4, 1.8, -0.3}, false, 20);
      meet(hit, from, ray, {-2.2, -1.2, -1.2}, {-1.7, 0.2, 0.4}, false, 30);
      meet(hit, from, ray, {0.2, -1.8, -1.2}, {1.0, -1.4, 0.0}, false, 40);
      const double z = hit.distance + noise * 0.0015 * hit.distance * hit.distance * gauss(random);
      view.depth.at<float>(y, x) = static_cast<float>(z);
      const auto value = cv::saturate_cast<unsigned char>(30 + 190 * hit.value + noise * 2 * gauss(random));
      view.bgr.at<cv::Vec3b>(y, x) = {value, value, value};
    }
  return view;
}

Drive::Drive(std::vector<Pose> path, double noise) : noise_(noise) {
  for (std::size_t i = 0; i < path.size(); ++i) {
    Frame frame;
    frame.name = "frame " + std::to_string(i);
    frame.pose = path[i];
    frames_.push_back(frame);
  }
  intrinsics_ = smallCamera();
}

void Drive::stamp(const std::vector<double>& seconds) {
  for (std::size_t i = 0; i < seconds.size(); ++i) frames_[i].timestamp = seconds[i];
}

cv::Mat Drive::image(std::size_t i) const {
  if (covered.contains(i)) return {120, 160, CV_8UC3, cv::Scalar::all(128)};
  return render(*frames_[i].pose, smallCamera(), noise_, static_cast<unsigned>(i)).bgr;
}

cv::Mat Drive::depth(std::size_t i) const {
  if (noDepthFile.contains(i))
    throw Error(ErrorCode::fileUnreadable, "frame " + std::to_string(i) + ": no depth image");
  if (covered.contains(i)) return {120, 160, CV_32F, cv::Scalar(0.1)};
  const CameraIntrinsics camera = smallCamera().scaledTo(160 / shrink, 120 / shrink);
  cv::Mat depth = render(*frames_[i].pose, camera, noise_, static_cast<unsigned>(i)).depth;
  if (noDepthValues.contains(i)) depth.setTo(0);
  if (cutDepth > 0) depth = depth.colRange(0, depth.cols - cutDepth).clone();
  return depth * unit;
}

std::vector<Pose> turnAround(int frames, int again) {
  std::vector<Pose> path;
  for (int i = 0; i < frames + again; ++i) {
    const double turn = 2 * std::numbers::pi * i / frames;
    path.push_back(Pose::planar(0.3 * std::cos(turn), 0.2 * std::sin(turn), turn));
  }
  return path;
}

FrameWords wordsByHeading(const Sequence& sequence) {
  constexpr int words = 24;
  return {.describe =
              [&sequence](std::size_t i) {
                const auto ahead = sequence.frame(i).pose->forward();
                const double heading = std::atan2(ahead[1], ahead[0]);
                LexicalDescriptor descriptor(words);
                for (int w = 0; w < words; ++w)
                  descriptor[static_cast<std::size_t>(w)] = static_cast<float>(
                      std::exp(3 * std::cos(heading - 2 * std::numbers::pi * w / words)) / 130);
                return descriptor;
              },
          .parts = {}};
}

double errorOf(const RgbdTrajectory& trajectory, const Sequence& sequence) {
  std::vector<Pose> estimated, truth;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (trajectory.poses[i]) {
      estimated.push_back(*trajectory.poses[i]);
      truth.push_back(*sequence.frame(i).pose);
    }
  return absoluteTrajectoryError(estimated, truth).rmse;
}

}  // namespace estancia::test
