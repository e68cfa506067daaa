// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/pcd.hpp"

namespace estancia {
namespace {

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
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\nWIDTH "
      "{}\n"
      "HEIGHT {}\nVIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA {}\n",
      fields, sizes, types, counts, cloud.width, cloud.height, at.x, at.y, at.z, at.qw, at.qx, at.qy, at.qz,
      cloud.points.size(), ascii ? "ascii" : "binary");
}

std::string textOf(const PointCloud& cloud) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    fmt::format_to(out, "{} {} {}", p.x, p.y, p.z);
    if (!cloud.colors.empty()) fmt::format_to(out, " {}", packed(cloud.colors[i]));
    if (!cloud.normals.empty()) {
      const cv::Point3f& n = cloud.normals[i];
      fmt::format_to(out, " {} {} {}", n.x, n.y, n.z);
    }
    text += '\n';
  }
  return text;
}

std::string bytesOf(const PointCloud& cloud) {
  ByteWriter bytes;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (const float value : {cloud.points[i].x, cloud.points[i].y, cloud.points[i].z}) bytes.number(value);
    if (!cloud.colors.empty()) bytes.number(packed(cloud.colors[i]));
    if (cloud.normals.empty()) continue;
    for (const float value : {cloud.normals[i].x, cloud.normals[i].y, cloud.normals[i].z})
      bytes.number(value);
  }
  return bytes.bytes();
}

}  // namespace

void writePcd(const PointCloud& cloud, const std::filesystem::path& file, bool ascii) {
  validate(cloud);
  if (cloud.points.empty())
    fail(ErrorCode::invalidInput, "{}: an empty cloud is not written", io::printable(file));
  writeWhole(file, headerOf(cloud, ascii) + (ascii ? textOf(cloud) : bytesOf(cloud)));
}

}  // namespace estancia
