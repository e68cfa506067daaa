#include "estancia/io/cloud_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "estancia/core/error.hpp"
#include "estancia/io/camera_file.hpp"
#include "estancia/io/depth_file.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/image_file.hpp"
#include "estancia/io/pcd.hpp"

namespace estancia {
namespace {

CameraIntrinsics cameraOf(const std::filesystem::path& image, const CloudFileOptions& options) {
  auto file = options.intrinsics;
  const auto folder = std::filesystem::absolute(image).parent_path();
  if (file.empty()) file = io::findIntrinsics(folder);
  if (file.empty()) file = io::findIntrinsics(folder.parent_path());
  if (file.empty())
    throw Error(
        fmt::format("{}: nothing says which camera took this depth image; give its intrinsics (fx fy cx cy)",
                    io::printable(image.string())));
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
    cv::resize(io::readImage(options.colors), colors, depth.size(), 0, 0, cv::INTER_AREA);
    cloud.colors.assign(colors.begin<cv::Vec3b>(), colors.end<cv::Vec3b>());
  }
  return cloud;
}

}  // namespace

PointCloud readCloud(const std::filesystem::path& file, const CloudFileOptions& options) {
  if (io::hasSuffix(file, {".pcd"})) return readPcd(file);
  if (io::hasSuffix(file, {".ply"})) return readPly(file);
  if (io::hasSuffix(file, io::depthSuffixes())) return readDepthImage(file, options);
  throw Error(fmt::format("{}: no cloud by its name; read are .pcd, .ply, and depth images {}",
                          io::printable(file.string()), fmt::join(io::depthSuffixes(), ", ")));
}

bool isCloudFile(const std::filesystem::path& file) {
  std::string start(8, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  const auto begins = [&](std::string_view magic) { return start.starts_with(magic); };
  return begins("ply\n") || begins("ply\r") || begins("# .PCD v") || begins("VERSION ") || begins("FIELDS ");
}

void requireCloudFile(const std::filesystem::path& file, bool edges) {
  if (io::hasSuffix(file, {".ply"}) || (!edges && io::hasSuffix(file, {".pcd"}))) return;
  throw Error(fmt::format("{}: a {}; end its name so", io::printable(file.string()),
                          edges ? "graph is written as .ply" : "cloud is written as .pcd or .ply"));
}

void writeCloud(const std::filesystem::path& file, const PointCloud& cloud, const CloudEdges& edges) {
  requireCloudFile(file, !edges.empty());
  if (io::hasSuffix(file, {".ply"}))
    writePly(file, cloud, edges);
  else
    writePcd(file, cloud);
}

}  // namespace estancia
