#include "estancia/cloud/crop_object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

const cv::Scalar kGray(128, 128, 128);

void requireValid(const CropOptions& options) {
  if (!(options.margin >= 0 && options.margin <= 4) || !(options.crop >= 0.25 && options.crop <= 1))
    throw Error(fmt::format("a patch has no margin of {} and crop of {}; give 0 … 4 and 0.25 … 1",
                            options.margin, options.crop));
}

/// How many times the thing's longer side the patch is wide.
double widthOf(const CropOptions& options) {
  return (1 + 2 * options.margin) / options.crop;
}

/// The extent of points along two axes, and which depths they have along a third.
struct Extent {
  cv::Vec3d least = cv::Vec3d::all(std::numeric_limits<double>::infinity());
  cv::Vec3d most = -least;

  void add(const cv::Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
      least[k] = std::min(least[k], p[k]);
      most[k] = std::max(most[k], p[k]);
    }
  }
  cv::Vec3d size() const { return most - least; }
};

/// Rows: to the right, down, away from the viewer.
using View = cv::Matx33d;

/// What a viewer sees who stands that way from the thing; z is up.
View viewFrom(double azimuth, double elevation) {
  const double ca = std::cos(azimuth), sa = std::sin(azimuth), ce = std::cos(elevation),
               se = std::sin(elevation);
  return {-sa, ca, 0, se * ca, se * sa, -ce, -ce * ca, -ce * sa, -se};
}

/// The viewing direction out of 24 around and 5 above from which the points fill most cells of a grid about
/// two points wide: there fewest hide each other.
View bestView(const std::vector<cv::Vec3d>& points) {
  constexpr std::size_t most = 20000;
  constexpr int around = 24, above = 5, finest = 512;
  const std::size_t step = (points.size() + most - 1) / most;
  Extent extent;
  for (const cv::Vec3d& p : points) extent.add(p);
  const cv::Vec3d size = extent.size();
  const double face = std::max({size[0] * size[1], size[1] * size[2], size[0] * size[2]});
  const double spacing = std::sqrt(face * static_cast<double>(step) / static_cast<double>(points.size()));
  const double diagonal = cv::norm(size), cell = std::max(2 * spacing, diagonal / finest);
  if (!(cell > 0)) return viewFrom(0, 0);  // a single place

  constexpr int side = finest + 2;  // a projection is at most as long as the diagonal
  std::vector<uchar> filledBy(static_cast<std::size_t>(side) * side, 0);
  static_assert(around * above < 255, "each direction leaves its own number in the cells");
  View best;
  int bestCount = -1;
  uchar number = 0;
  const cv::Vec3d middle = (extent.least + extent.most) / 2;
  for (int e = 0; e < above; ++e)
    for (int a = 0; a < around; ++a) {
      const View view = viewFrom(2 * std::numbers::pi * a / around, std::numbers::pi / 9 * e);
      ++number;
      int count = 0;
      for (std::size_t i = 0; i < points.size(); i += step) {
        const cv::Vec3d p = view * (points[i] - middle);
        const auto x = static_cast<std::size_t>(p[0] / cell + side / 2.0),
                   y = static_cast<std::size_t>(p[1] / cell + side / 2.0);
        uchar& by = filledBy[y * side + x];
        count += by == number ? 0 : 1;
        by = number;
      }
      if (count > bestCount) {
        bestCount = count;
        best = view;
      }
    }
  return best;
}

/// The square of a patch around `box`, which may reach beyond the image.
cv::Rect squareAround(const cv::Rect& box, const CropOptions& options) {
  requireValid(options);
  constexpr double widest = 16384;
  const double side = std::ceil(std::max(box.width, box.height) * widthOf(options));
  if (side > widest)
    throw Error(fmt::format("a patch of {} pixels is wider than {}; give a smaller margin", side, widest));
  const int n = static_cast<int>(side);
  return {box.x - (n - box.width) / 2, box.y - (n - box.height) / 2, n, n};
}

}  // namespace

cv::Mat cropObject(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask, const CropOptions& options) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    throw Error("a patch is cut out of an image with three channels of 8 bits; convert it");
  if (box.x < 0 || box.y < 0 || box.width <= 0 || box.height <= 0 || box.width > bgr.cols ||
      box.height > bgr.rows || box.x > bgr.cols - box.width || box.y > bgr.rows - box.height)
    throw Error(fmt::format("the box {} × {} at ({}, {}) does not lie in the image of {} × {}", box.width,
                            box.height, box.x, box.y, bgr.cols, bgr.rows));
  const bool kept = options.background == CropOptions::Background::kept;
  if (!kept && mask.empty())
    throw Error(
        "which pixels are the thing is not known here, so its background cannot be replaced; keep it");
  if (!mask.empty() && (mask.size() != bgr.size() || mask.type() != CV_8UC1))
    throw Error(fmt::format("a mask of {} × {} for an image of {} × {}; give one of its size, 8 bits",
                            mask.cols, mask.rows, bgr.cols, bgr.rows));
  const cv::Rect square = squareAround(box, options);

  cv::Scalar fill = kGray;
  if (options.background == CropOptions::Background::mean) {
    if (cv::countNonZero(mask(box)) == 0) throw Error("the mask marks nothing in the box of the thing");
    fill = cv::mean(bgr(box), mask(box));
  }
  const cv::Rect there = square & cv::Rect({}, bgr.size());
  cv::Mat patch(square.size(), CV_8UC3, fill);
  bgr(there).copyTo(patch(there - square.tl()), kept ? cv::Mat() : mask(there));
  return patch;
}

cv::Mat renderObject(const PointCloud& cloud, int size, const CropOptions& options) {
  requireValid(options);
  validate(cloud);
  constexpr int largest = 4096;
  if (size < 1 || size > largest)
    throw Error(fmt::format("an image of {} pixels; give 1 … {}", size, largest));
  std::vector<cv::Vec3d> points;
  std::vector<std::size_t> from;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isFinite(cloud.points[i])) {
      points.emplace_back(cloud.points[i].x, cloud.points[i].y, cloud.points[i].z);
      from.push_back(i);
    }
  if (points.empty()) throw Error("no point of the cloud is finite, so there is nothing to draw");

  const View view = bestView(points);
  Extent extent;
  for (cv::Vec3d& p : points) {
    p = view * p;
    extent.add(p);
  }
  const cv::Vec3d thing = extent.size(), middle = (extent.least + extent.most) / 2;
  const double longer = std::max(thing[0], thing[1]);
  const double scale = longer > 0 ? size / (longer * widthOf(options)) : 0;
  // Discs that just close the surface where points are spread evenly over the image of it.
  constexpr double overlap = 1.1;
  const double spacing = scale * std::sqrt(thing[0] * thing[1] / static_cast<double>(points.size()));
  const int radius =
      static_cast<int>(std::clamp(std::ceil(overlap * spacing), 2.0, std::max(2.0, size / 8.0)));

  cv::Mat image(size, size, CV_8UC3, kGray);
  cv::Mat depth(size, size, CV_64F, cv::Scalar(std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Vec3d& p = points[i];
    constexpr double darkest = 60, brightest = 230;
    const double near = thing[2] > 0 ? (extent.most[2] - p[2]) / thing[2] : 1;
    const cv::Vec3b color =
        cloud.colors.empty()
            ? cv::Vec3b::all(cv::saturate_cast<uchar>(darkest + near * (brightest - darkest)))
            : cloud.colors[from[i]];
    const int x = static_cast<int>(std::lround((p[0] - middle[0]) * scale + (size - 1) / 2.0));
    const int y = static_cast<int>(std::lround((p[1] - middle[1]) * scale + (size - 1) / 2.0));
    for (int v = std::max(0, y - radius); v <= std::min(size - 1, y + radius); ++v)
      for (int u = std::max(0, x - radius); u <= std::min(size - 1, x + radius); ++u) {
        const int du = u - x, dv = v - y;
        if (du * du + dv * dv > radius * radius || p[2] >= depth.at<double>(v, u)) continue;
        depth.at<double>(v, u) = p[2];
        image.at<cv::Vec3b>(v, u) = color;
      }
  }
  return image;
}

}  // namespace estancia
