// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/area_resize.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t channels = 3;

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
      std::memcpy(&pixel, row + (first + t) * channels, sizeof pixel);
      sum += share[t] * pixel;
    }
    std::memcpy(to, &sum, sizeof sum);
    share += taps;
    to += channels;
  }
}

using ShrinkRow = void (*)(const float*, const Axis&, float*);

ShrinkRow shrinkRowFor(std::size_t taps) {
  switch (taps) {
    case 3:
      return shrinkRow<3>;
    case 4:
      return shrinkRow<4>;
    default:
      return shrinkRow<0>;
  }
}

}  // namespace

cv::Mat resizeByArea(const cv::Mat& image, cv::Size size) {
  CV_Assert(image.type() == CV_8UC3 && size.width > 0 && size.height > 0 && size.width <= image.cols &&
            size.height <= image.rows);
  const Axis columns = axisOf(image.cols, size.width), rows = axisOf(image.rows, size.height);
  const ShrinkRow shrinkRow = shrinkRowFor(columns.taps);
  const std::size_t before = static_cast<std::size_t>(image.cols) * channels,
                    after = static_cast<std::size_t>(size.width) * channels;
  std::vector<float> row(before + columns.taps * channels + 1), shrunk(after + 1), sums(after + 1);
  int last = -1;  // the old row in `shrunk`: two new ones may share it
  cv::Mat result(size, CV_8UC3);
  const float* share = rows.shares.data();
  for (int y = 0; y < size.height; ++y, share += rows.taps) {
    std::fill(sums.begin(), sums.end(), 0.0F);
    for (std::size_t t = 0; t < rows.taps && share[t] > 0; ++t) {
      const int k = static_cast<int>(rows.first[static_cast<std::size_t>(y)] + t);
      if (k != last) {
        toFloats(image.ptr<uchar>(k), before, row.data());
        shrinkRow(row.data(), columns, shrunk.data());
      }
      last = k;
      add(sums, share[t], shrunk);
    }
    toBytes(sums, result.ptr<uchar>(y), after);
  }
  return result;
}

}  // namespace estancia
