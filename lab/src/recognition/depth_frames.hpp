// Depth frames: real depth images, with made-up models put into them where something flat carries them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "recognition/made_up_models.hpp"

namespace estancia::experiments {

struct DepthFrame {
  std::string name;
  /// CV_32F [m]; 0 where there is none.
  cv::Mat depth;
  CameraIntrinsics camera;
};

/// Where the frames come from: a folder with an index.csv (readObjectScenes(); a Kinect's camera), or a drive
/// with depth and camera.
struct DepthFrameSource {
  std::string name;
  std::filesystem::path path;
  /// This many, evenly spread.
  std::size_t frames = 20;
};

/// Names of the frames, in order. Throws Error when they cannot be listed.
std::vector<std::string> namesOfFrames(const DepthFrameSource& source);
/// The frame of that number. Throws Error when it cannot be read.
DepthFrame readFrame(const DepthFrameSource& source, std::size_t number);

enum class Placement { standing, lying, stacked, byWall };
/// "standing" …
std::string nameOf(Placement placement);

/// A model in a frame.
struct PlacedModel {
  cv::Mat depth;
  /// T_camera_model.
  cv::Affine3d pose;
  /// Share of its silhouette that something is in front of.
  double hidden = 0;
};

/// Puts the model on a flat place of the frame that is large enough, where the frame shows nothing in front
/// of it or in it, and something in front of it that hides about `hidden` of it. Its depths have the noise
/// (1.3 mm · z²) and steps (2.85 mm · z²) of a Kinect (Khoshelham, Oude Elberink, Sensors 12, 2012). With
/// `likeView` it stands turned as its one-sided cloud shows it. None where no place is found. A function of
/// the seed.
std::optional<PlacedModel> place(const MadeUpModel& model, const DepthFrame& frame, Placement placement,
                                 double hidden, bool likeView, std::uint64_t seed);

}  // namespace estancia::experiments
