// Color cases: colored models to look for in colored scenes, and where they truly are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia::experiments {

struct ColorCases {
  struct Model {
    std::string name;
    /// "flat", "shaped", or the kind of a made-up thing.
    std::string group;
    PointCloud cloud;
    /// T_model_model after which it looks the same, without the identity.
    std::vector<cv::Affine3d> symmetries;
  };
  struct Scene {
    std::string name;
    PointCloud cloud;
  };
  struct Search {
    std::size_t scene = 0, model = 0;
    /// T_scene_model; none: it is not there.
    std::vector<cv::Affine3d> truth;
    /// Where things of the same shape stand that are not the model [m].
    std::vector<cv::Point3d> lookAlikes;
  };
  std::vector<Model> models;
  std::vector<Scene> scenes;
  /// Even ones are for choosing, odd ones for reporting: pairs and absent models alternate.
  std::vector<Search> searches;
};

/// How models and scenes are taken from a drive with poses and depth.
struct DriveCasesOptions {
  std::filesystem::path path;
  /// Models are the things of instance/*.png, else the clusters of a frame.
  bool instances = false;
  /// Models come from one of this many frames.
  std::size_t every = 10;
  /// Pixels with depth of the smallest model.
  std::size_t minPixels = 1500;
  /// Standard deviation of noise that is added to depth [m at 1 m]; it grows with the square of depth.
  double noise = 0;
  std::uint64_t seed = 1;
  /// Models, evenly spread over those that are found.
  std::size_t models = 20;
};

/// Each model is a thing cut out of a frame that shows it whole. It is looked for in a frame that sees at
/// least 60 % of it from another direction (10° to 45°, that nearest to 20°), and in one that sees nothing of
/// it. Models whose normals hardly leave a plane ("flat": the second largest share of their scatter is below
/// 5 %) are distinguished from others. Throws Error (invalidInput, insufficientData) on a drive without
/// depth, camera or poses, and when it gives no case.
ColorCases casesOfDrive(const DriveCasesOptions& options);

/// `count` frames of a drive, evenly spread. Throws Error as casesOfDrive() does.
std::vector<PointCloud> framesOfDrive(const DriveCasesOptions& options, std::size_t count);

/// Made-up tables with three things of one shape each: plain cans, cans that are printed in the same two
/// colors, boxes whose sides have the same four colors in another order. One is the model, or none of them.
/// `scenes` of each kind; views of a camera like a Kinect, with its noise, under changing light.
ColorCases lookAlikeCases(std::size_t scenes, std::uint64_t seed);

}  // namespace estancia::experiments
