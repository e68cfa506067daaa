// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/scene_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
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
void join(PointCloud& all, const PointCloud& cloud, const cv::Affine3d& toMap) {
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!isMeasured(cloud.points[i])) continue;
    all.points.emplace_back(toMap * cv::Point3d(cloud.points[i]));
    all.colors.push_back(cloud.colors[i]);
  }
  all.width = all.points.size();
  all.height = 1;
}

/// A frame on its way into the map.
struct View {
  PointCloud cloud;
  cv::Affine3d toMap;
};

/// By how much two frames differ in depth where both see a surface [m]: the median of what is below 10 cm, as
/// more is another surface; 0 where they see none in common.
double disagreementOf(const View& one, const View& other, const CameraIntrinsics& camera) {
  if (one.cloud.points.empty()) return 0;
  const cv::Affine3d toOne = one.toMap.inv() * other.toMap;
  const auto width = static_cast<int>(one.cloud.width), height = static_cast<int>(one.cloud.height);
  const CameraIntrinsics own = camera.scaledTo(width, height);
  std::vector<double> differences;
  for (const cv::Point3f& point : other.cloud.points) {
    const cv::Point3d p = toOne * cv::Point3d(point);  // a hole is NaN, which nothing below accepts
    const double u = own.fx * p.x / p.z + own.cx, v = own.fy * p.y / p.z + own.cy;
    if (!(p.z > 0 && u > 0 && v > 0 && u < width - 1 && v < height - 1)) continue;
    const auto at = static_cast<std::size_t>(std::lround(v) * width + std::lround(u));
    const double difference = std::abs(static_cast<double>(one.cloud.points[at].z) - p.z);
    if (difference < 0.1) differences.push_back(difference);
  }
  if (differences.empty()) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::ranges::nth_element(differences, middle);
  return *middle;
}

/// The frames in the map, with the spacing of one frame's points; a wider one where the frames disagree by
/// more, as poses that are a centimeter off show surfaces twice, which finer points would keep apart.
PointCloud joined(const Sequence& drive, const std::vector<std::size_t>& frames) {
  PointCloud all;
  double spacing = 0, disagreement = 0;
  View before;
  for (const std::size_t i : frames) {
    if (!drive.frame(i).pose)
      fail(ErrorCode::insufficientData,
           "{}: {} has no pose to join it to the others by; give a trajectory by --poses, or one frame",
           drive.name(), drive.frame(i).name);
    View view{cloudOf(drive, i), rigidOf(*drive.frame(i).pose)};
    spacing += resolutionOf(view.cloud) / static_cast<double>(frames.size());
    disagreement = std::max(disagreement, disagreementOf(before, view, *drive.intrinsics()));
    join(all, view.cloud, view.toMap);
    before = std::move(view);
  }
  const double leaf = std::max(spacing, disagreement);
  return leaf > 0 ? voxelGrid(all, leaf) : all;
}

SceneCloud readFrames(const Sequence& drive, const std::vector<std::string>& chosen) {
  requireDepthAndCamera(drive);
  const std::vector<std::size_t> frames = framesOf(drive, chosen);
  SceneCloud scene;
  scene.warnings = drive.warnings();
  for (const std::size_t i : frames) scene.frames.push_back(drive.frame(i));
  scene.reference = frames.size() > 1 ? "map" : "camera";
  scene.cloud = frames.size() > 1 ? joined(drive, frames) : cloudOf(drive, frames[0]);
  return scene;
}

}  // namespace

SceneCloud readSceneCloud(const std::filesystem::path& path, const SceneCloudOptions& options) {
  const bool isImage = io::hasSuffix(path, io::depthSuffixes());
  std::error_code missing;  // openSequence() and readCloud() report it
  if (std::filesystem::is_directory(path, missing) || (!isImage && !io::hasSuffix(path, {".pcd", ".ply"}))) {
    if (std::filesystem::is_regular_file(path, missing) && options.frames.empty())
      fail(ErrorCode::unsupportedFile,
           "{}: no cloud (.pcd, .ply) and no depth image; if it is a bag, choose frames of it by --frame",
           io::printable(path));
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
