// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/scene_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace estancia {
namespace {

void requireDepthAndCamera(const Sequence& drive) {
  if (!drive.hasDepth())
    fail(ErrorCode::insufficientData,
         "{} has no depth images, which a scene needs; give a drive with depth, or a cloud", drive.name());
  if (!drive.intrinsics())
    fail(ErrorCode::insufficientData,
         "{} has no camera intrinsics; give a file of fx fy cx cy by --intrinsics", drive.name());
}

/// Its place in the drive, by its name or its number.
std::size_t frameOf(const Sequence& drive, const std::string& chosen) {
  for (std::size_t i = 0; i < drive.size(); ++i)
    if (drive.frame(i).name == chosen) return i;
  const auto number = io::toNumber(chosen);
  if (!number || !(*number >= 0 && *number < static_cast<double>(drive.size())) ||
      *number != std::floor(*number))
    fail(ErrorCode::unknownName, "{} has no frame \"{}\"; give a number from 0 to {}, or a name such as {}",
         drive.name(), io::printable(chosen), drive.size() - 1, drive.frame(0).name);
  return static_cast<std::size_t>(*number);
}

std::vector<std::size_t> framesOf(const Sequence& drive, const std::vector<std::string>& chosen) {
  if (chosen.empty() && drive.size() != 1)
    fail(ErrorCode::invalidOption, "{} is a drive of {} frames; choose some by --frame, such as --frame {}",
         drive.name(), drive.size(), drive.size() / 2);
  if (chosen.empty()) return {0};
  std::vector<std::size_t> frames;
  for (const std::string& one : chosen) {
    frames.push_back(frameOf(drive, one));
    if (std::ranges::count(frames, frames.back()) > 1)
      fail(ErrorCode::invalidOption, "--frame {} is given twice; give each frame once", io::printable(one));
  }
  return frames;
}

/// In the camera's frame, with the colors of the image.
PointCloud cloudOf(const Sequence& drive, std::size_t frame) {
  PointCloud cloud = backProject(drive.depth(frame), *drive.intrinsics());
  const cv::Size size(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  cv::Mat colors;
  cv::resize(drive.image(frame), colors, size, 0, 0, cv::INTER_AREA);
  cloud.colors.assign(colors.begin<cv::Vec3b>(), colors.end<cv::Vec3b>());
  cloud.viewpoint = Pose();
  return cloud;
}

/// The measured points of a frame, moved into the map.
void join(PointCloud& all, const PointCloud& cloud, const Frame& frame) {
  const cv::Affine3d toMap = rigidOf(*frame.pose);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!isMeasured(cloud.points[i])) continue;
    all.points.emplace_back(toMap * cv::Point3d(cloud.points[i]));
    all.colors.push_back(cloud.colors[i]);
  }
  all.width = all.points.size();
  all.height = 1;
}

SceneCloud readFrames(const Sequence& drive, const std::vector<std::string>& chosen) {
  requireDepthAndCamera(drive);
  SceneCloud scene;
  scene.warnings = drive.warnings();
  const std::vector<std::size_t> frames = framesOf(drive, chosen);
  for (const std::size_t i : frames) {
    scene.frames.push_back(drive.frame(i));
    if (frames.size() > 1 && !drive.frame(i).pose)
      fail(ErrorCode::insufficientData,
           "{}: {} has no pose to join it to the others by; give a trajectory by --poses, or one frame",
           drive.name(), drive.frame(i).name);
  }
  scene.reference = frames.size() > 1 ? "map" : "camera";
  if (frames.size() == 1)
    scene.cloud = cloudOf(drive, frames[0]);
  else
    for (const std::size_t i : frames) join(scene.cloud, cloudOf(drive, i), drive.frame(i));
  return scene;
}

}  // namespace

SceneCloud readSceneCloud(const std::filesystem::path& path, const SceneCloudOptions& options) {
  const bool isImage = io::hasSuffix(path, io::depthSuffixes());
  if (std::filesystem::is_directory(path) || (!isImage && !io::hasSuffix(path, {".pcd", ".ply"}))) {
    if (options.file.unit != "m" || !options.file.colors.empty())
      fail(ErrorCode::invalidOption,
           "{}: a drive has its own colors, and --depth-scale, its depth units per meter; leave {} out",
           io::printable(path), options.file.unit != "m" ? "--scene-unit" : "--colors");
    return readFrames(*openSequence(path, options.sequence), options.frames);
  }
  if (!options.frames.empty())
    fail(ErrorCode::invalidOption, "--frame chooses frames of a drive, and {} is {}; leave it out",
         io::printable(path), isImage ? "a depth image" : "a cloud");
  CloudFileOptions file = options.file;
  file.depthScale = options.sequence.depthScale;
  file.intrinsics = options.sequence.intrinsics;
  SceneCloud scene;
  scene.cloud = readCloud(path, file);
  if (isImage) {
    scene.cloud.viewpoint = Pose();
    scene.reference = "camera";
  }
  return scene;
}

}  // namespace estancia
