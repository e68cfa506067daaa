#include "estancia/io/depth_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/image_file.hpp"
#include "estancia/io/pcd.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr double kFurthest = 1e6;  // [m]; more is damage, not depth

/// What is usual where nobody says: millimeters, 255 for 10 m (as NYU Depth V2 is passed around), meters.
double usualUnits(int depth) {
  return depth == CV_8U ? 25.5 : depth == CV_16U ? 1000 : 1;
}

/// The only channel of an image. Gray images are often saved with three.
cv::Mat onlyChannel(const cv::Mat& image, const fs::path& file) {
  if (image.channels() == 1) return image;
  cv::Mat first, other;
  cv::extractChannel(image, first, 0);
  for (int c = 1; c < std::min(image.channels(), 3); ++c) {
    cv::extractChannel(image, other, c);
    if (cv::norm(first, other, cv::NORM_INF) != 0)
      throw Error(
          fmt::format("{}: colors are no depth; export depth with one channel, 16 bits in millimeters",
                      printable(file.string())));
  }
  return first;
}

cv::Mat depthOfCloud(const fs::path& file, double unitsPerMeter) {
  const PointCloud cloud = readPcd(file);
  if (!cloud.organized())
    throw Error(
        fmt::format("{}: its points are in no order, so that it has no depth image; save it organized",
                    printable(file.string())));
  cv::Mat meters = depthOf(cloud);
  if (unitsPerMeter > 0) meters.convertTo(meters, CV_32F, 1 / unitsPerMeter);
  return meters;
}

}  // namespace

cv::Mat readDepth(const fs::path& file, double unitsPerMeter) {
  if (hasSuffix(file, {".pcd"})) return depthOfCloud(file, unitsPerMeter);
  const cv::Mat raw = onlyChannel(decodeImage(file, cv::IMREAD_UNCHANGED), file);
  const int kind = raw.depth();
  if (kind != CV_8U && kind != CV_16U && kind != CV_32F && kind != CV_64F)
    throw Error(fmt::format("{}: depth has 8 or 16 bits without sign, or is float; convert it",
                            printable(file.string())));
  cv::Mat meters;
  raw.convertTo(meters, CV_32F);
  const double units = unitsPerMeter > 0 ? unitsPerMeter : usualUnits(kind);
  const float invalid = kind == CV_16U ? 65535.F : std::numeric_limits<float>::infinity();
  meters.forEach<float>([=](float& d, const int*) {
    const double scaled = d / units;
    d = d > 0 && d < invalid && scaled < kFurthest ? static_cast<float>(scaled) : 0;
  });
  return meters;
}

const std::vector<std::string>& depthSuffixes() {
  static const std::vector<std::string> suffixes = {".png", ".tif", ".tiff", ".exr", ".pfm", ".pgm"};
  return suffixes;
}

DepthFile nearestDepth(const std::vector<TimedFile>& files, double time) {
  constexpr double most = 0.02;  // [s]
  if (files.empty()) return {};
  auto nearest = std::ranges::lower_bound(files, time, {}, &TimedFile::timestamp);
  if (nearest == files.end() ||
      (nearest != files.begin() && time - std::prev(nearest)->timestamp < nearest->timestamp - time))
    --nearest;
  const bool own = std::abs(nearest->timestamp - time) <= most;
  return {own ? nearest->file : fs::path(), nearest->timestamp};
}

}  // namespace estancia::io
