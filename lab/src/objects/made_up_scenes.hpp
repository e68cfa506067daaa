// Made-up scenes: tables with boxes and cylinders, rendered as a Kinect sees them, with their true objects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

#include "estancia/core/camera.hpp"

namespace estancia::experiments {

struct MadeUpScene {
  /// What is hard about it: clutter, side by side, gaps, coaxial, stacks, slits, printed.
  std::string category;
  /// BGR; the same view as `depth`.
  cv::Mat image;
  /// CV_32F [m]; 0 where there is none.
  cv::Mat depth;
  /// CV_32S, the number of the object from 2 on, 0 elsewhere; without noise.
  cv::Mat truth;
  CameraIntrinsics camera;
};

/// A function of the seed. Depth has the noise (1.3 mm · z²) and the steps (2.85 mm · z²) of a Kinect
/// (Khoshelham, Oude Elberink, Sensors 12, 2012), .6 pixels of lateral noise (Nguyen, Izadi, Lovell, 3DIMPVT
/// 2012), and shadows beside what is near.
MadeUpScene madeUpScene(std::uint64_t seed);

/// "clutter" …, by the seed.
std::string madeUpCategory(std::uint64_t seed);

}  // namespace estancia::experiments
