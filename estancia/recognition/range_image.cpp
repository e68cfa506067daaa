// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace estancia {

RangeImage::RangeImage(std::span<const cv::Point3f> points, double spacing) {
  constexpr double maxSlope = 4;  // 76° to either side
  constexpr int maxCells = 4'000'000;
  std::vector<float> zs;
  float left = maxSlope, right = -maxSlope, top = maxSlope, bottom = -maxSlope;
  for (const cv::Point3f& p : points) {
    if (!(p.z > 0) || std::abs(p.x) > maxSlope * p.z || std::abs(p.y) > maxSlope * p.z) return;
    left = std::min(left, p.x / p.z), right = std::max(right, p.x / p.z);
    top = std::min(top, p.y / p.z), bottom = std::max(bottom, p.y / p.z);
    zs.push_back(p.z);
  }
  if (zs.empty() || !(spacing > 0)) return;
  const auto middle = zs.begin() + static_cast<std::ptrdiff_t>(zs.size() / 2);
  std::nth_element(zs.begin(), middle, zs.end());
  medianDepth_ = static_cast<double>(*middle);
  const double edge = std::max(2.5 * spacing / static_cast<double>(*middle),
                               std::sqrt(static_cast<double>(right - left) * (bottom - top) / maxCells));
  left_ = left, top_ = top;
  perCell_ = static_cast<float>(1 / edge);
  columns_ = static_cast<int>((right - left_) * perCell_) + 1;
  rows_ = static_cast<int>((bottom - top_) * perCell_) + 1;
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  depths_.assign(cells, std::numeric_limits<float>::infinity());
  std::vector<float> farthest(cells, 0);
  for (const cv::Point3f& p : points) {
    const std::size_t cell = *cellOf(p);
    depths_[cell] = std::min(depths_[cell], p.z);
    farthest[cell] = std::max(farthest[cell], p.z);
  }
  constexpr double steep = 6;  // cells: rise of a surface at 80° within one cell
  std::size_t seen = 0, twice = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    if (farthest[i] == 0) continue;
    ++seen;
    if (farthest[i] - depths_[i] > steep * edge * depths_[i]) ++twice;
  }
  hiddenShare_ = static_cast<double>(twice) / static_cast<double>(seen);
  if (2 * twice > seen) {
    depths_.clear();
    return;
  }
  spreadDepths(farthest);
}

/// Minimum and maximum filter over 3 × 3 cells.
void RangeImage::spreadDepths(const std::vector<float>& farthest) {
  around_.assign(depths_.size(), {std::numeric_limits<float>::infinity(), 0});
  for (int r = 0; r < rows_; ++r)
    for (int c = 0; c < columns_; ++c) {
      const auto at = [&](int row, int column) {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(column);
      };
      Depths& sum = around_[at(r, c)];
      for (int y = std::max(0, r - 1); y <= std::min(rows_ - 1, r + 1); ++y)
        for (int x = std::max(0, c - 1); x <= std::min(columns_ - 1, c + 1); ++x) {
          sum.nearest = std::min(sum.nearest, depths_[at(y, x)]);
          sum.farthest = std::max(sum.farthest, farthest[at(y, x)]);
        }
    }
}

std::optional<float> RangeImage::depth(const cv::Point3f& place) const {
  const auto cell = cellOf(place);
  if (!cell || std::isinf(depths_[*cell])) return {};
  return depths_[*cell];
}

}  // namespace estancia
