// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/odometry/altered_drive.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/fail.hpp"

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

}  // namespace estancia::experiments
