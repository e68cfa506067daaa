// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/packed_image.hpp"

#include <cmath>
#include <vector>

#include "estancia/core/png.hpp"

namespace estancia::odometry {
namespace {

constexpr double maxPixels = 1 << 26;  // the limit of image files

cv::Mat readPngOf(ByteReader& bytes, cv::Size size, int type) {
  const std::vector<unsigned char> png = bytes.numbers<unsigned char>();
  const cv::Mat image = fromPng(png, size);
  if (image.size() != size || image.type() != type) bytes.fail("an image of a keyframe is damaged");
  return image;
}

}  // namespace

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
