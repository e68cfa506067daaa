// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/crop_object.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/cloud/bounds.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

const cv::Scalar grayColor(128, 128, 128);

/// Width of the crop in longer sides of the object.
double widthOf(const CropOptions& options) {
  return (1 + 2 * options.margin) / options.crop;
}

/// Rows: to the right, down, away from the viewer.
using View = cv::Matx33d;
using Box = Bounds<double>;

/// The view from this direction; z is up.
View viewFrom(double azimuth, double elevation) {
  const double ca = std::cos(azimuth), sa = std::sin(azimuth), ce = std::cos(elevation),
               se = std::sin(elevation);
  return {-sa, ca, 0, se * ca, se * sa, -ce, -ce * ca, -ce * sa, -se};
}

/// The viewing direction out of 24 azimuths and 5 elevations in which the points fill most cells of a grid of
/// about two spacings: there, fewest points occlude each other.
View bestView(const std::vector<cv::Vec3d>& points) {
  constexpr std::size_t maxPoints = 20000;
  constexpr int azimuths = 24, elevations = 5, maxCells = 512;
  const std::size_t step = (points.size() + maxPoints - 1) / maxPoints;
  Box box;
  for (const cv::Vec3d& p : points) box.add(p);
  const cv::Vec3d size = box.high - box.low;
  const double face = std::max({size[0] * size[1], size[1] * size[2], size[0] * size[2]});
  const double spacing = std::sqrt(face * static_cast<double>(step) / static_cast<double>(points.size()));
  const double diagonal = cv::norm(size), cell = std::max(2 * spacing, diagonal / maxCells);
  if (!(cell > 0)) return viewFrom(0, 0);  // all points coincide

  constexpr int side = maxCells + 2;  // a projection is at most as long as the diagonal
  std::vector<uchar> filledBy(static_cast<std::size_t>(side) * side, 0);
  static_assert(azimuths * elevations < 255, "each direction has its own number in the cells");
  View best;
  int bestCount = -1;
  uchar number = 0;
  const cv::Vec3d middle = (box.low + box.high) / 2;
  for (int e = 0; e < elevations; ++e)
    for (int a = 0; a < azimuths; ++a) {
      const View view = viewFrom(2 * std::numbers::pi * a / azimuths, std::numbers::pi / 9 * e);
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

/// The square of the crop around `box`, which may extend beyond the image.
cv::Rect squareAround(const cv::Rect& box, const CropOptions& options) {
  constexpr double maxSide = 16384;
  const double side = std::ceil(std::max(box.width, box.height) * widthOf(options));
  if (side > maxSide)
    fail(ErrorCode::tooLarge,
         "the crop would have {} pixels a side, at most {} are possible; give a smaller margin", side,
         maxSide);
  const int n = static_cast<int>(side);
  return {box.x - (n - box.width) / 2, box.y - (n - box.height) / 2, n, n};
}

void requireCropInput(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask, bool kept) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    throw Error(ErrorCode::invalidInput, "the image to crop is not 8-bit BGR; convert it");
  if (box.x < 0 || box.y < 0 || box.width <= 0 || box.height <= 0 || box.width > bgr.cols ||
      box.height > bgr.rows || box.x > bgr.cols - box.width || box.y > bgr.rows - box.height)
    fail(ErrorCode::invalidInput, "the box {} × {} at ({}, {}) is not inside of the image of {} × {}",
         box.width, box.height, box.x, box.y, bgr.cols, bgr.rows);
  if (!kept && mask.empty())
    throw Error(ErrorCode::invalidOption,
                "the background cannot be replaced without a mask of the object; give one, or keep it");
  if (!mask.empty() && (mask.size() != bgr.size() || mask.type() != CV_8UC1))
    fail(ErrorCode::mismatch,
         "the mask is {} × {} and the image {} × {}; give an 8-bit mask of the image's size", mask.cols,
         mask.rows, bgr.cols, bgr.rows);
}

/// The cloud's finite points as `view` shows them, and their indices.
struct Projected {
  std::vector<cv::Vec3d> points;
  std::vector<std::size_t> indices;
  Box box;
};

Projected projected(const PointCloud& cloud) {
  Projected result;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isFinite(cloud.points[i])) {
      result.points.emplace_back(cloud.points[i].x, cloud.points[i].y, cloud.points[i].z);
      result.indices.push_back(i);
    }
  if (result.points.empty())
    throw Error(ErrorCode::invalidInput, "no point of the cloud is finite, so there is nothing to render");
  const View view = bestView(result.points);
  for (cv::Vec3d& p : result.points) {
    p = view * p;
    result.box.add(p);
  }
  return result;
}

/// Draws a disc where it is nearer than what was drawn before.
void drawDisc(int x, int y, int radius, double z, const cv::Vec3b& color, cv::Mat& depth, cv::Mat& image) {
  for (int v = std::max(0, y - radius); v <= std::min(image.rows - 1, y + radius); ++v)
    for (int u = std::max(0, x - radius); u <= std::min(image.cols - 1, x + radius); ++u) {
      const int du = u - x, dv = v - y;
      if (du * du + dv * dv > radius * radius || z >= depth.at<double>(v, u)) continue;
      depth.at<double>(v, u) = z;
      image.at<cv::Vec3b>(v, u) = color;
    }
}

}  // namespace

OptionGroup declare(CropOptions& o) {
  using Background = CropOptions::Background;
  OptionGroup group("crop", "The image of one object that a classifier gets.");
  group.add("background", o.background,
            {{{"kept", "as in the image"}, Background::kept},
             {{"gray", "gray"}, Background::gray},
             {{"mean", "the mean color of the object"}, Background::mean}},
            "Pixels around the object");
  group.add("margin", &o.margin, "Added on every side, as a share of the object's longer side").range(0, 4);
  group.add("crop", &o.crop, "Central part of an image's side that the classifier uses").range(0.25, 1);
  return group;
}

cv::Mat cropObject(const cv::Mat& bgr, const cv::Rect& box, const cv::Mat& mask, const CropOptions& options) {
  const bool kept = options.background == CropOptions::Background::kept;
  requireCropInput(bgr, box, mask, kept);
  validate(options);
  const cv::Rect square = squareAround(box, options);

  cv::Scalar fill = grayColor;
  if (options.background == CropOptions::Background::mean) {
    if (cv::countNonZero(mask(box)) == 0)
      throw Error(ErrorCode::invalidInput, "the mask has no pixel in the box of the object");
    fill = cv::mean(bgr(box), mask(box));
  }
  const cv::Rect visible = square & cv::Rect({}, bgr.size());
  cv::Mat crop(square.size(), CV_8UC3, fill);
  bgr(visible).copyTo(crop(visible - square.tl()), kept ? cv::Mat() : mask(visible));
  return crop;
}

cv::Mat renderObject(const PointCloud& cloud, int size, const CropOptions& options) {
  validate(options);
  validate(cloud);
  constexpr int maxSize = 4096;
  if (size < 1 || size > maxSize)
    fail(ErrorCode::invalidOption, "the image's size is {}; give 1 to {}", size, maxSize);
  const auto [points, indices, box] = projected(cloud);
  const cv::Vec3d object = box.high - box.low, middle = (box.low + box.high) / 2;
  const double longer = std::max(object[0], object[1]);
  const double scale = longer > 0 ? size / (longer * widthOf(options)) : 0;
  // Discs that just close the surface where points are spread evenly over the image.
  const double spacing = scale * std::sqrt(object[0] * object[1] / static_cast<double>(points.size()));
  const int radius = static_cast<int>(std::clamp(std::ceil(1.1 * spacing), 2.0, std::max(2.0, size / 8.0)));

  cv::Mat image(size, size, CV_8UC3, grayColor);
  cv::Mat depth(size, size, CV_64F, cv::Scalar(std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Vec3d& p = points[i];
    constexpr double darkest = 60, brightest = 230;
    const double near = object[2] > 0 ? (box.high.z - p[2]) / object[2] : 1;
    const cv::Vec3b color =
        cloud.colors.empty()
            ? cv::Vec3b::all(cv::saturate_cast<uchar>(darkest + near * (brightest - darkest)))
            : cloud.colors[indices[i]];
    const int x = static_cast<int>(std::lround((p[0] - middle[0]) * scale + (size - 1) / 2.0));
    const int y = static_cast<int>(std::lround((p[1] - middle[1]) * scale + (size - 1) / 2.0));
    drawDisc(x, y, radius, p[2], color, depth, image);
  }
  return image;
}

}  // namespace estancia
