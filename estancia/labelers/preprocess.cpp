// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/network_labeler.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t colorCount = 3;

/// The old pixels along one axis that each new one covers: `taps` of them from its `first` on, and how much
/// of it each of them is; 0 for those beyond its end.
struct Axis {
  std::size_t taps = 1;
  std::vector<std::size_t> first;
  std::vector<float> shares;
};

Axis axisOf(int from, int to) {
  const double scale = static_cast<double>(from) / to;
  constexpr double nothing = 1e-3;  // rounding tolerance [pixels]
  Axis axis;
  axis.taps = static_cast<std::size_t>(scale) + 2;  // its ends may lie within pixels
  axis.shares.resize(axis.taps * static_cast<std::size_t>(to));
  float* share = axis.shares.data();
  for (int i = 0; i < to; ++i, share += axis.taps) {
    const double start = i * scale, end = std::min<double>(start + scale, from);
    const int first = static_cast<int>(start + nothing);
    for (int k = first; k < from && end - k > nothing; ++k)
      share[k - first] = static_cast<float>((std::min(end, k + 1.0) - std::max<double>(start, k)) / scale);
    axis.first.push_back(static_cast<std::size_t>(first));
  }
  return axis;
}

ESTANCIA_MULTIVERSION void toFloats(const uchar* pixels, std::size_t count, float* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = pixels[i];
}

ESTANCIA_MULTIVERSION void add(std::vector<float>& sums, float share, const std::vector<float>& row) {
  const std::size_t count = sums.size();
  float* const to = sums.data();
  const float* const from = row.data();
  for (std::size_t i = 0; i < count; ++i) to[i] += share * from[i];
}

/// Rounds to even where both are as near, as OpenCV does.
ESTANCIA_MULTIVERSION void toBytes(const std::vector<float>& sums, uchar* to, std::size_t count) {
  constexpr float oneAndAHalf = 0x1.8p23F;  // a sum with it has no bits left for fractions
  const float* const from = sums.data();
  for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<uchar>((from[i] + oneAndAHalf) - oneAndAHalf);
}

/// Shrinks a row: each new pixel is a sum of four lanes, its colors and what follows them, which the next one
/// overwrites. `fixed`: the number of taps, where it is known when this is compiled; else 0.
template <std::size_t fixed>
void shrinkRow(const float* row, const Axis& axis, float* to) {
  using Four = Simd<4>::Float;
  const std::size_t taps = fixed == 0 ? axis.taps : fixed;
  const float* share = axis.shares.data();
  for (const std::size_t first : axis.first) {
    Four sum{};
    for (std::size_t t = 0; t < taps; ++t) {
      Four pixel;
      std::memcpy(&pixel, row + (first + t) * colorCount, sizeof pixel);
      sum += share[t] * pixel;
    }
    std::memcpy(to, &sum, sizeof sum);
    share += taps;
    to += colorCount;
  }
}

/// `share` of `size`, at least one pixel, in the middle.
cv::Range centered(int size, double length) {
  const int kept = std::clamp(static_cast<int>(std::lround(length)), 1, size);
  const int start = (size - kept) / 2;
  return {start, start + kept};
}

cv::Mat centerOf(const cv::Mat& image, const Preprocessing& how) {
  const double side = how.crop * std::min(image.rows, image.cols);
  const bool square = how.region == Preprocessing::Region::square;
  return image(centered(image.rows, square ? side : how.crop * image.rows),
               centered(image.cols, square ? side : how.crop * image.cols));
}

cv::Mat toInputSize(const cv::Mat& region, const Preprocessing& how) {
  const cv::Size size(how.width, how.height);
  const bool shrinks = region.cols > size.width || region.rows > size.height;
  const bool byArea = how.resize == Preprocessing::Resize::area && shrinks;
  // OpenCV is quick where each pixel is the mean of a block.
  const bool blocks = region.cols % size.width == 0 && region.rows % size.height == 0;
  if (byArea && !blocks && region.type() == CV_8UC3 && size.width <= region.cols &&
      size.height <= region.rows)
    return resizeByArea(region, size);
  const bool cubic = how.resize == Preprocessing::Resize::cubic;
  cv::Mat resized;
  cv::resize(region, resized, size, 0, 0,
             byArea  ? cv::INTER_AREA
             : cubic ? cv::INTER_CUBIC
                     : cv::INTER_LINEAR);
  return resized;
}

/// 8 bits, three channels in the network's order.
cv::Mat colors(const cv::Mat& image, Preprocessing::Color order) {
  cv::Mat bytes = image;
  if (image.depth() == CV_16U) image.convertTo(bytes, CV_8U, 1 / 257.0);  // 65535 / 257 = 255
  const bool rgb = order == Preprocessing::Color::rgb;
  const int channels = bytes.channels();
  if (channels == 3 && !rgb) return bytes;
  const int alpha = rgb ? cv::COLOR_BGRA2RGB : cv::COLOR_BGRA2BGR;
  cv::Mat result;
  cv::cvtColor(bytes, result, channels == 1 ? cv::COLOR_GRAY2BGR : channels == 4 ? alpha : cv::COLOR_BGR2RGB);
  return result;
}

}  // namespace

cv::Mat resizeByArea(const cv::Mat& image, cv::Size size) {
  CV_Assert(image.type() == CV_8UC3 && size.width > 0 && size.height > 0 && size.width <= image.cols &&
            size.height <= image.rows);
  const Axis columns = axisOf(image.cols, size.width), rows = axisOf(image.rows, size.height);
  const auto shrink = columns.taps == 3 ? shrinkRow<3> : columns.taps == 4 ? shrinkRow<4> : shrinkRow<0>;
  const std::size_t before = static_cast<std::size_t>(image.cols) * colorCount,
                    after = static_cast<std::size_t>(size.width) * colorCount;
  std::vector<float> row(before + columns.taps * colorCount + 1), shrunk(after + 1), sums(after + 1);
  int last = -1;  // the old row in `shrunk`: two new ones may share it
  cv::Mat result(size, CV_8UC3);
  const float* share = rows.shares.data();
  for (int y = 0; y < size.height; ++y, share += rows.taps) {
    std::fill(sums.begin(), sums.end(), 0.0F);
    for (std::size_t t = 0; t < rows.taps && share[t] > 0; ++t) {
      const int k = static_cast<int>(rows.first[static_cast<std::size_t>(y)] + t);
      if (k != last) {
        toFloats(image.ptr<uchar>(k), before, row.data());
        shrink(row.data(), columns, shrunk.data());
      }
      last = k;
      add(sums, share[t], shrunk);
    }
    toBytes(sums, result.ptr<uchar>(y), after);
  }
  return result;
}

cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how) {
  if (image.empty() || image.dims != 2) fail(ErrorCode::invalidInput, "an empty image cannot be labeled");
  const int channels = image.channels();
  if ((image.depth() != CV_8U && image.depth() != CV_16U) ||
      (channels != 1 && channels != 3 && channels != 4))
    fail(ErrorCode::invalidInput,
         "an image of {} channels of type {} cannot be labeled; give gray, BGR or BGRA of 8 or 16 bits",
         channels, cv::depthToString(image.depth()));
  const cv::Mat region = centerOf(image, how);
  const cv::Mat resized = colors(toInputSize(region, how), how.color);

  cv::Mat blob({1, 3, how.height, how.width}, CV_32F);
  std::array<cv::Mat, 3> planes;
  cv::split(resized, planes);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    cv::Mat plane(how.height, how.width, CV_32F, blob.ptr<float>(0, c));
    planes[i].convertTo(plane, CV_32F, how.scale[i], -how.mean[i] * how.scale[i]);
  }
  return blob;
}

}  // namespace estancia
