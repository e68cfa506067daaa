// A made-up drive with depth as the files of a recording.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "estancia/sequences/sequence.hpp"
#include "support/support.hpp"

namespace estancia::test {

/// Writes rgb/0000.png …, depth/ (millimeters), intrinsics.txt and poses.txt, which openSequence() reads.
inline void writeDrive(const Sequence& drive, const std::filesystem::path& folder) {
  for (const char* part : {"rgb", "depth"}) std::filesystem::create_directories(folder / part);
  std::string poses;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    cv::Mat millimeters;
    drive.depth(i).convertTo(millimeters, CV_16U, 1000);
    const std::string name = fmt::format("{:04}.png", i);
    cv::imwrite(folder / "rgb" / name, drive.image(i));
    cv::imwrite(folder / "depth" / name, millimeters);
    const Pose p = drive.frame(i).pose.value();
    poses += fmt::format("{} {} {} {} {} {} {} {}\n", i, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
  }
  writeFile(folder / "poses.txt", poses);
  const CameraIntrinsics camera = drive.intrinsics().value();
  writeFile(folder / "intrinsics.txt",
            fmt::format("{} {} {} {}\n", camera.fx, camera.fy, camera.cx, camera.cy));
}

}  // namespace estancia::test
