// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/depth_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/files/pcd.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// Default units per meter: millimeters, 255 for 10 m (common copies of NYU Depth V2), meters.
double defaultUnits(int depth) {
  return depth == CV_8U ? 25.5 : depth == CV_16U ? 1000 : 1;
}

cv::Mat depthOfCloud(const fs::path& file, double unitsPerMeter) {
  const PointCloud cloud = readPcd(file);
  if (!cloud.organized())
    fail(ErrorCode::unsupportedFile, "{}: an unorganized cloud has no depth image; save it organized",
         printable(file));
  cv::Mat meters = depthOf(cloud);
  if (unitsPerMeter > 0) meters.convertTo(meters, CV_32F, 1 / unitsPerMeter);
  return meters;
}

}  // namespace

cv::Mat metersOf(const cv::Mat& raw, double unitsPerMeter, const std::string& name) {
  const int kind = raw.depth();
  if (raw.channels() != 1 || (kind != CV_8U && kind != CV_16U && kind != CV_32F && kind != CV_64F))
    fail(ErrorCode::unsupportedFile, "{}: depth must be unsigned 8 or 16 bits, or float; convert it", name);
  cv::Mat meters;
  raw.convertTo(meters, CV_32F);
  const double units = unitsPerMeter > 0 ? unitsPerMeter : defaultUnits(kind);
  const float invalid = kind == CV_16U ? 65535.F : std::numeric_limits<float>::infinity();
  meters.forEach<float>([=](float& d, const int*) {
    const double scaled = d / units;
    d = d > 0 && d < invalid && scaled < 1e6 ? static_cast<float>(scaled) : 0;
  });
  return meters;
}

cv::Mat readDepth(const fs::path& file, double unitsPerMeter) {
  if (hasSuffix(file, {".pcd"})) return depthOfCloud(file, unitsPerMeter);
  const cv::Mat depth = onlyChannel(decodeImage(file));
  if (depth.empty())
    fail(ErrorCode::unsupportedFile,
         "{}: a color image, not depth; export depth with one channel, 16 bits in millimeters",
         printable(file));
  return metersOf(depth, unitsPerMeter, printable(file));
}

const std::vector<std::string>& depthSuffixes() {
  static const std::vector<std::string> suffixes = {".png", ".tif", ".tiff", ".exr", ".pfm", ".pgm"};
  return suffixes;
}

DepthFile nearestDepth(const std::vector<TimedFile>& files, double time) {
  if (files.empty()) return {};
  const auto nearest = nearestInTime(files, time, &TimedFile::timestamp);
  const bool own = std::abs(nearest->timestamp - time) <= 0.02;  // [s]
  return {own ? nearest->file : fs::path(), nearest->timestamp};
}

}  // namespace estancia::io
