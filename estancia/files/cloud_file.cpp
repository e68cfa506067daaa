// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/cloud_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <iterator>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
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
         "{}: the camera of this depth image is unknown; give a file of fx fy cx cy by --intrinsics",
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

PointCloud inMeters(PointCloud cloud, const std::string& unit) {
  if (unit == "m") return cloud;
  const float perMeter = unit == "mm" ? 1000 : 100;
  for (cv::Point3f& p : cloud.points) p /= perMeter;
  if (cloud.viewpoint)
    for (double* at : {&cloud.viewpoint->x, &cloud.viewpoint->y, &cloud.viewpoint->z})
      *at /= static_cast<double>(perMeter);
  return cloud;
}

/// Binary numbers, or lines of text.
class Body {
 public:
  explicit Body(bool ascii) : ascii_(ascii) {}
  template <class Value>
  void number(Value value) {
    if (!ascii_)
      binary_.number(value);
    else
      fmt::format_to(std::back_inserter(text_), "{} ", value);
  }
  void numbers(const cv::Point3f& p) {
    for (const float value : {p.x, p.y, p.z}) number(value);
  }
  void endElement() {
    if (ascii_) text_.back() = '\n';
  }
  const std::string& bytes() const { return ascii_ ? text_ : binary_.bytes(); }

 private:
  bool ascii_;
  ByteWriter binary_;
  std::string text_;
};

std::uint32_t packed(const cv::Vec3b& bgr) {
  return std::uint32_t{bgr[2]} << 16U | std::uint32_t{bgr[1]} << 8U | std::uint32_t{bgr[0]};
}

std::string headerOf(const PointCloud& cloud, bool ascii) {
  std::string fields = "x y z", sizes = "4 4 4", types = "F F F", counts = "1 1 1";
  if (!cloud.colors.empty()) fields += " rgb", sizes += " 4", types += " U", counts += " 1";
  if (!cloud.normals.empty())
    fields += " normal_x normal_y normal_z", sizes += " 4 4 4", types += " F F F", counts += " 1 1 1";
  const Pose at = cloud.viewpoint.value_or(Pose());
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
      "WIDTH {}\nHEIGHT {}\nVIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA {}\n",
      fields, sizes, types, counts, cloud.width, cloud.height, at.x, at.y, at.z, at.qw, at.qx, at.qy, at.qz,
      cloud.points.size(), ascii ? "ascii" : "binary");
}

constexpr std::uint32_t leftOut = std::numeric_limits<std::uint32_t>::max();

/// The vertex of each point.
std::vector<std::uint32_t> verticesOf(const PointCloud& cloud) {
  std::vector<std::uint32_t> vertices;
  vertices.reserve(cloud.points.size());
  std::uint32_t next = 0;
  for (const cv::Point3f& p : cloud.points) vertices.push_back(isFinite(p) ? next++ : leftOut);
  return vertices;
}

std::string headerOf(const PointCloud& cloud, std::size_t vertices, std::size_t edges, bool ascii) {
  std::string header = fmt::format("ply\nformat {} 1.0\nelement vertex {}\n",
                                   ascii ? "ascii" : "binary_little_endian", vertices);
  header += "property float x\nproperty float y\nproperty float z\n";
  if (!cloud.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!cloud.colors.empty()) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (edges > 0)
    header += fmt::format("element edge {}\nproperty int vertex1\nproperty int vertex2\n", edges);
  return header + "end_header\n";
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

Choices lengthUnits() {
  return {{"m", "meters"}, {"cm", "centimeters"}, {"mm", "millimeters"}};
}

PointCloud readCloud(const std::filesystem::path& file, const CloudFileOptions& options) {
  validate(options);
  requireChoice("unit of length", options.unit, lengthUnits());
  if (io::hasSuffix(file, {".pcd"})) return inMeters(readPcd(file), options.unit);
  if (io::hasSuffix(file, {".ply"})) return inMeters(readPly(file), options.unit);
  if (io::hasSuffix(file, io::depthSuffixes())) {
    if (options.unit != "m")
      fail(ErrorCode::invalidOption,
           "{}: the unit {} is that of a cloud, and this is a depth image; give its units per meter "
           "(--depth-scale) instead",
           io::printable(file), options.unit);
    return readDepthImage(file, options);
  }
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

void writePcd(const PointCloud& cloud, const std::filesystem::path& file, bool ascii) {
  validate(cloud);
  if (cloud.points.empty())
    fail(ErrorCode::invalidInput, "{}: an empty cloud is not written", io::printable(file));
  Body body(ascii);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    body.numbers(cloud.points[i]);
    if (!cloud.colors.empty()) body.number(packed(cloud.colors[i]));
    if (!cloud.normals.empty()) body.numbers(cloud.normals[i]);
    body.endElement();
  }
  writeWhole(file, headerOf(cloud, ascii) + body.bytes());
}

void writePly(const PointCloud& cloud, const std::filesystem::path& file, const CloudEdges& edges,
              bool ascii) {
  const auto refuse = [&](const std::string& why) {
    fail(ErrorCode::invalidInput, "{}: {}", io::printable(file), why);
  };
  validate(cloud);
  constexpr auto maxPoints = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (cloud.points.size() > maxPoints) refuse("too many points for a PLY file; downsample the cloud");
  const auto vertices = verticesOf(cloud);
  Body body(ascii);
  std::size_t written = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i] == leftOut) continue;
    ++written;
    body.numbers(cloud.points[i]);
    if (!cloud.normals.empty()) body.numbers(cloud.normals[i]);
    if (!cloud.colors.empty())
      for (const int c : {2, 1, 0}) body.number(cloud.colors[i][c]);
    body.endElement();
  }
  if (written == 0) refuse("an empty cloud is not written");
  for (const auto& [from, to] : edges) {
    if (from >= vertices.size() || to >= vertices.size() || vertices[from] == leftOut ||
        vertices[to] == leftOut)
      refuse(fmt::format("the edge from point {} to {} has a missing point", from, to));
    body.number(static_cast<std::int32_t>(vertices[from]));
    body.number(static_cast<std::int32_t>(vertices[to]));
    body.endElement();
  }
  writeWhole(file, headerOf(cloud, written, edges.size(), ascii) + body.bytes());
}

}  // namespace estancia
