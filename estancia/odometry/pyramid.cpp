// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "estancia/core/png.hpp"

namespace estancia::odometry {
namespace {

constexpr float noDepth = std::numeric_limits<float>::quiet_NaN();
constexpr float sameSurface = 0.03F;  // share of the depth: pixels that differ by more lie on two surfaces
constexpr int minSize = 24;
constexpr double maxPixels = 1 << 26;  // the limit of image files

/// The mean of the nearest surface in every 2 × 2 pixels: averaging across an edge would create points in
/// free space.
cv::Mat halvedDepth(const cv::Mat& depth) {
  cv::Mat half(depth.rows / 2, depth.cols / 2, CV_32F);
  for (int y = 0; y < half.rows; ++y) {
    const float* above = depth.ptr<float>(2 * y);
    const float* below = depth.ptr<float>(2 * y + 1);
    for (int x = 0; x < half.cols; ++x) {
      const float four[] = {above[2 * x], above[2 * x + 1], below[2 * x], below[2 * x + 1]};
      float nearest = std::numeric_limits<float>::infinity(), sum = 0;
      for (const float z : four)
        if (z > 0) nearest = std::min(nearest, z);
      int count = 0;
      for (const float z : four)
        if (z > 0 && z <= nearest * (1 + sameSurface)) sum += z, ++count;
      half.at<float>(y, x) = count > 0 ? sum / static_cast<float>(count) : 0;
    }
  }
  return half;
}

RgbdImage halved(const RgbdImage& image) {
  const CameraIntrinsics& c = image.camera;
  RgbdImage half;
  half.depth = halvedDepth(image.depth);
  // An odd last row or column is left out, so that pixels keep their rays.
  half.camera = {half.depth.cols, half.depth.rows,        c.fx / 2,
                 c.fy / 2,        (c.cx + 0.5) / 2 - 0.5, (c.cy + 0.5) / 2 - 0.5};
  const cv::Rect even(0, 0, half.depth.cols * 2, half.depth.rows * 2);
  cv::resize(image.gray(even), half.gray, half.depth.size(), 0, 0, cv::INTER_AREA);
  return half;
}

cv::Mat pointsOf(const cv::Mat& depth, const CameraIntrinsics& camera) {
  cv::Mat points(depth.size(), CV_32FC3);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const float z = depth.at<float>(y, x);
      points.at<cv::Vec3f>(y, x) = {static_cast<float>(camera.slopeX(x)) * z,
                                    static_cast<float>(camera.slopeY(y)) * z, z};
    }
  return points;
}

/// From the four neighbors; none across the edge of a surface.
cv::Mat normalsOf(const cv::Mat& points) {
  cv::Mat normals(points.size(), CV_32FC3, cv::Scalar::all(noDepth));
  for (int y = 1; y + 1 < points.rows; ++y)
    for (int x = 1; x + 1 < points.cols; ++x) {
      const cv::Vec3f across = points.at<cv::Vec3f>(y, x + 1) - points.at<cv::Vec3f>(y, x - 1);
      const cv::Vec3f down = points.at<cv::Vec3f>(y + 1, x) - points.at<cv::Vec3f>(y - 1, x);
      const float edge = 3 * sameSurface * points.at<cv::Vec3f>(y, x)[2];
      const cv::Vec3f normal = down.cross(across);
      const auto length = static_cast<float>(cv::norm(normal));
      if (length > 0 && std::abs(across[2]) < edge && std::abs(down[2]) < edge)  // false for NaN
        normals.at<cv::Vec3f>(y, x) = normal * (1 / length);
    }
  return normals;
}

PyramidLevel levelOf(const RgbdImage& image) {
  PyramidLevel level;
  level.camera = image.camera;
  cv::GaussianBlur(image.gray, level.gray, {3, 3}, 0);
  level.depth = image.depth.clone();
  level.depth.setTo(noDepth, image.depth <= 0);
  level.points = pointsOf(level.depth, level.camera);
  level.normals = normalsOf(level.points);
  cv::Sobel(level.gray, level.grayDx, CV_32F, 1, 0);
  cv::Sobel(level.gray, level.grayDy, CV_32F, 0, 1);
  return level;
}

cv::Mat readPngOf(ByteReader& bytes, cv::Size size, int type) {
  const std::vector<unsigned char> png = bytes.numbers<unsigned char>();
  const cv::Mat image = fromPng(png, size);
  if (image.size() != size || image.type() != type) bytes.fail("an image of a keyframe is damaged");
  return image;
}

}  // namespace

bool sameShape(cv::Size a, cv::Size b) {
  const double ratio = static_cast<double>(a.width) * b.height / (static_cast<double>(a.height) * b.width);
  return std::abs(ratio - 1) < 0.02;
}

RgbdImage reducedImage(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera, int width,
                       double maxDepth) {
  RgbdImage image;
  image.camera = camera;
  image.depth = depth.clone();
  image.depth.setTo(0, depth > maxDepth);
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::resize(gray, gray, depth.size(), 0, 0, gray.cols > depth.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
  gray.convertTo(image.gray, CV_32F, 1.0 / 255);
  while (image.depth.cols > width && std::min(image.depth.cols, image.depth.rows) / 2 >= minSize)
    image = halved(image);
  return image;
}

Pyramid pyramidOf(const RgbdImage& image, int levels) {
  Pyramid pyramid{levelOf(image)};
  RgbdImage next = image;
  while (static_cast<int>(pyramid.size()) < levels &&
         std::min(next.depth.cols, next.depth.rows) / 2 >= minSize) {
    next = halved(next);
    pyramid.push_back(levelOf(next));
  }
  return pyramid;
}

PackedImage packed(const RgbdImage& image, double maxDepth) {
  PackedImage packed{image.camera, {}, cv::Mat(image.depth.size(), CV_16U), maxDepth / 65535};
  image.gray.convertTo(packed.gray, CV_8U, 255);
  for (int y = 0; y < image.depth.rows; ++y) {
    const float* depth = image.depth.ptr<float>(y);
    auto* steps = packed.depth.ptr<std::uint16_t>(y);
    for (int x = 0; x < image.depth.cols; ++x)
      steps[x] = depth[x] > 0  // false for NaN
                     ? cv::saturate_cast<std::uint16_t>(static_cast<double>(depth[x]) / packed.step)
                     : std::uint16_t{0};
  }
  return packed;
}

RgbdImage unpacked(const PackedImage& image) {
  RgbdImage unpacked{image.camera, {}, {}};
  image.gray.convertTo(unpacked.gray, CV_32F, 1.0 / 255);
  image.depth.convertTo(unpacked.depth, CV_32F, image.step);
  return unpacked;
}

void write(const CameraIntrinsics& c, ByteWriter& bytes) {
  bytes.number(c.width), bytes.number(c.height);
  for (const double value : {c.fx, c.fy, c.cx, c.cy}) bytes.number(value);
}

CameraIntrinsics readCamera(ByteReader& bytes) {
  CameraIntrinsics c;
  c.width = bytes.number<int>(), c.height = bytes.number<int>();
  for (double* value : {&c.fx, &c.fy, &c.cx, &c.cy}) *value = bytes.number<double>();
  if (c.width < 1 || c.height < 1 || !(c.fx > 0) || !(c.fy > 0) || !std::isfinite(c.cx + c.cy))
    bytes.fail("a keyframe has no camera");
  return c;
}

void write(const PackedImage& image, ByteWriter& bytes) {
  write(image.camera, bytes);
  bytes.number(image.step);
  bytes.numbers(toPng(image.gray));
  bytes.numbers(toPng(image.depth));
}

PackedImage readPackedImage(ByteReader& bytes) {
  PackedImage image;
  image.camera = readCamera(bytes);
  image.step = bytes.number<double>();
  const cv::Size size(image.camera.width, image.camera.height);
  if (static_cast<double>(size.width) * size.height > maxPixels || !(image.step > 0))
    bytes.fail("an image of a keyframe has no size");
  image.gray = readPngOf(bytes, size, CV_8U);
  image.depth = readPngOf(bytes, size, CV_16U);
  return image;
}

}  // namespace estancia::odometry
