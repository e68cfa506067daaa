#include "estancia/recognition/range_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace estancia {

RangePicture::RangePicture(std::span<const cv::Point3f> points, double spacing) {
  constexpr double widest = 4;  // slope: 76° to either side
  constexpr int mostCells = 4'000'000;
  std::vector<float> zs;
  float left = widest, right = -widest, top = widest, bottom = -widest;
  for (const cv::Point3f& p : points) {
    if (!(p.z > 0) || std::abs(p.x) > widest * p.z || std::abs(p.y) > widest * p.z) return;
    left = std::min(left, p.x / p.z), right = std::max(right, p.x / p.z);
    top = std::min(top, p.y / p.z), bottom = std::max(bottom, p.y / p.z);
    zs.push_back(p.z);
  }
  if (zs.empty() || !(spacing > 0)) return;
  const auto middle = zs.begin() + static_cast<std::ptrdiff_t>(zs.size() / 2);
  std::nth_element(zs.begin(), middle, zs.end());
  cell_ = std::max(2.5 * spacing / static_cast<double>(*middle),
                   std::sqrt(static_cast<double>(right - left) * (bottom - top) / mostCells));
  left_ = left, top_ = top;
  columns_ = static_cast<int>((right - left_) / cell_) + 1;
  rows_ = static_cast<int>((bottom - top_) / cell_) + 1;
  depths_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                 std::numeric_limits<float>::infinity());
  for (const cv::Point3f& p : points) {
    const int c = static_cast<int>((static_cast<double>(p.x / p.z) - left_) / cell_);
    const int r = static_cast<int>((static_cast<double>(p.y / p.z) - top_) / cell_);
    float& depth =
        depths_[static_cast<std::size_t>(std::clamp(r, 0, rows_ - 1)) * static_cast<std::size_t>(columns_) +
                static_cast<std::size_t>(std::clamp(c, 0, columns_ - 1))];
    depth = std::min(depth, p.z);
  }
}

std::optional<float> RangePicture::depth(const cv::Point3f& place) const {
  if (depths_.empty() || !(place.z > 0)) return {};
  const double c = std::floor((static_cast<double>(place.x / place.z) - left_) / cell_);
  const double r = std::floor((static_cast<double>(place.y / place.z) - top_) / cell_);
  if (!(c >= 0) || !(r >= 0) || c >= columns_ || r >= rows_) return {};
  const float depth =
      depths_[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c)];
  if (std::isinf(depth)) return {};
  return depth;
}

}  // namespace estancia
