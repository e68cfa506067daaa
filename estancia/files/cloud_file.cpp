// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/cloud_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/files/camera_file.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/files/path_option.hpp"
#include "estancia/files/pcd.hpp"
#include "estancia/files/ply.hpp"

namespace estancia {
namespace {

CameraIntrinsics cameraOf(const std::filesystem::path& image, const CloudFileOptions& options) {
  auto file = options.intrinsics;
  const auto folder = std::filesystem::absolute(image).parent_path();
  if (file.empty()) file = io::findIntrinsics(folder);
  if (file.empty()) file = io::findIntrinsics(folder.parent_path());
  if (file.empty())
    fail(ErrorCode::insufficientData,
         "{}: the camera of this depth image is unknown; give its intrinsics (fx fy cx cy)",
         io::printable(image));
  return io::readIntrinsics(file);
}

PointCloud readDepthImage(const std::filesystem::path& file, const CloudFileOptions& options) {
  CameraIntrinsics camera = cameraOf(file, options);
  const cv::Mat depth = io::readDepth(file, options.depthScale);
  if (camera.width == 0) {
    camera.width = depth.cols;
    camera.height = depth.rows;
  }
  PointCloud cloud = backProject(depth, camera);
  if (!options.colors.empty()) {
    cv::Mat colors;
    cv::resize(readImage(options.colors), colors, depth.size(), 0, 0, cv::INTER_AREA);
    cloud.colors.assign(colors.begin<cv::Vec3b>(), colors.end<cv::Vec3b>());
  }
  return cloud;
}

}  // namespace

OptionGroup declare(CloudFileOptions& o) {
  OptionGroup group("cloud-file", "How to read depth images as point clouds.");
  group.add("depth-scale", &o.depthScale, "Depth units per meter; 0: default of the image type")
      .range(0, 1e9);
  group.add("intrinsics", io::asText(o.intrinsics), "Camera intrinsics: fx fy cx cy, 3×3 matrix, or YAML")
      .automatic("camera-intrinsics.txt, intrinsics.txt or camera.yaml in the folder or the one above");
  group.add("colors", io::asText(o.colors), "Color image of the same view").automatic("no colors");
  return group;
}

PointCloud readCloud(const std::filesystem::path& file, const CloudFileOptions& options) {
  validate(options);
  if (io::hasSuffix(file, {".pcd"})) return readPcd(file);
  if (io::hasSuffix(file, {".ply"})) return readPly(file);
  if (io::hasSuffix(file, io::depthSuffixes())) return readDepthImage(file, options);
  fail(ErrorCode::unsupportedFile,
       "{}: not the extension of a point cloud; use .pcd, .ply, or a depth image {}", io::printable(file),
       fmt::join(io::depthSuffixes(), ", "));
}

bool isCloudFile(const std::filesystem::path& file) {
  const std::string start = io::firstBytes(file, 8);
  const auto begins = [&](std::string_view magic) { return start.starts_with(magic); };
  return begins("ply\n") || begins("ply\r") || begins("# .PCD v") || begins("VERSION ") || begins("FIELDS ");
}

void requireCloudFile(const std::filesystem::path& file, bool edges) {
  if (io::hasSuffix(file, {".ply"}) || (!edges && io::hasSuffix(file, {".pcd"}))) return;
  fail(ErrorCode::unsupportedFile, "{}: {}", io::printable(file),
       edges ? "a graph is written as .ply" : "a point cloud is written as .pcd or .ply");
}

void writeCloud(const PointCloud& cloud, const std::filesystem::path& file, const CloudEdges& edges) {
  requireCloudFile(file, !edges.empty());
  if (io::hasSuffix(file, {".ply"}))
    writePly(cloud, file, edges);
  else
    writePcd(cloud, file);
}

}  // namespace estancia
