// SPDX-License-Identifier: Apache-2.0
#include "odometry/altered_drive.hpp"

#include <algorithm>
#include <numbers>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::experiments {

AlteredDrive::AlteredDrive(std::shared_ptr<const Sequence> drive, const DriveAlteration& alteration)
    : drive_(std::move(drive)), alteration_(alteration) {
  if (alteration_.every < 1 || !(alteration_.noise >= 0))
    fail(ErrorCode::invalidOption, "every is {} and noise is {}; give 1 or more, and 0 or more",
         alteration_.every, alteration_.noise);
  intrinsics_ = drive_->intrinsics();
  poseSource_ = drive_->poseSource();
  warnings_ = drive_->warnings();
}

std::size_t AlteredDrive::size() const {
  return (drive_->size() + alteration_.every - 1) / alteration_.every;
}

cv::Mat AlteredDrive::depth(std::size_t i) const {
  cv::Mat depth = drive_->depth(original(i)).clone();
  if (alteration_.noise == 0) return depth;
  cv::RNG random((alteration_.seed << 32U) + original(i) + 1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u), deviation = random.gaussian(alteration_.noise * z * z);
      if (z > 0) depth.at<float>(v, u) = static_cast<float>(std::max(z + deviation, 0.0));
    }
  return depth;
}

std::vector<std::optional<Pose>> AlteredDrive::wheels() const {
  std::vector<std::optional<Pose>> wheels;
  if (alteration_.wheelShift == 0 && alteration_.wheelTurn == 0) return wheels;
  cv::RNG random((alteration_.seed << 32U) + alteration_.every);
  std::optional<Pose> before;  // the true one
  cv::Affine3d odom = cv::Affine3d::Identity();
  for (std::size_t i = 0; i < size(); ++i) {
    const std::optional<Pose>& truth = frame(i).pose;
    wheels.emplace_back();
    if (!truth) continue;
    if (before) {
      const cv::Affine3d step = rigidOf(*before).inv() * rigidOf(*truth);
      const double length = 1 + random.gaussian(alteration_.wheelShift / 100);
      const double turn = random.gaussian(alteration_.wheelTurn * std::numbers::pi / 180);
      const cv::Affine3d measured(step.rotation(), step.translation() * length);
      odom = odom * measured * cv::Affine3d(cv::Vec3d(0, turn, 0));  // y of the camera is down
    }
    wheels.back() = poseOf(odom);
    before = truth;
  }
  return wheels;
}

}  // namespace estancia::experiments
