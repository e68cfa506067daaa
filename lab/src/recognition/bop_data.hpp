// BOP data sets: models with their symmetries, and images with cameras, targets and true poses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <opencv2/core/affine.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/files/ply.hpp"
#include "recognition/depth_frames.hpp"

namespace estancia::experiments {

/// A folder in the layout of the BOP challenge (Hodaň et al., ECCV 2018 and ECCV workshops 2020).
struct BopSource {
  /// Its short name, which results have, too: "lmo".
  std::string name;
  std::filesystem::path path;
  /// The folder of its scenes: "test", "test_primesense".
  std::string split = "test";
  /// The file of its targets.
  std::string targets = "test_targets_bop19.json";
  /// This many of its images, evenly spread; 0: all.
  std::size_t images = 0;
  /// What may be this much behind a measured depth is visible, for VSD [m].
  double delta = 0.015;
  /// Results in BOP's format to be judged; "": those of the library are found and judged.
  std::filesystem::path results;
  /// Left out, with a note, when it is not there.
  bool optional = false;
};

struct BopObject {
  /// [m]
  PlyMesh mesh;
  /// [m]
  double diameter = 0;
  /// T_model_model after which it looks the same, the identity first; a continuous one in steps.
  std::vector<cv::Affine3d> symmetries;
};

/// What is to be found in an image: this many instances of an object.
struct BopTarget {
  int object = 0;
  std::size_t instances = 1;
};

/// An instance that is in an image, or an estimate.
struct BopInstance {
  int object = 0;
  /// T_camera_model [m].
  cv::Affine3d pose;
  /// Share of its silhouette that is seen.
  double visible = 0;
};

struct BopImage {
  int scene = 0, image = 0;
  /// By object.
  std::vector<BopTarget> targets = {};
  std::vector<BopInstance> truth = {};
  /// Size 0: that of the depth image.
  CameraIntrinsics camera = {};
  std::filesystem::path depth = {};
  double unitsPerMeter = 0;
};

struct BopData {
  std::vector<BopImage> images;
  /// The targets' objects, by number.
  std::map<int, BopObject> objects;
};

/// Reads all but the depth images. Models are those of models_eval, if it is there, else of models. Throws
/// Error that names the file, on any that is missing or breaks the format.
BopData readBop(const BopSource& source);

/// Throws Error when it cannot be read.
DepthFrame readBopDepth(const BopImage& image);

/// A rotation, row by row, and a translation [mm]. Throws Error (malformedFile) when it is no rotation,
/// rounded.
cv::Affine3d bopPose(std::span<const double> rotation, std::span<const double> translation);

/// Rotations around a line through `offset` by equal steps, the identity first: a point moves by 1 % of the
/// diameter at most, if it is half a diameter away. Throws Error (malformedFile) without a direction.
std::vector<cv::Affine3d> bopTurns(const cv::Vec3d& axis, const cv::Vec3d& offset);

/// Points of the triangles, evenly, `step` apart on average, 1000 … 200,000 of them.
PointCloud sampleMesh(const PlyMesh& mesh, double step);

}  // namespace estancia::experiments
