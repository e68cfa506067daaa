// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/area_plan.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/areas/grown_image.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr double maxCells = 24e6;  // 240 × 240 m at 5 cm; each takes 50 bytes on the way to areas

/// Positions that no grid reaches are all as far away, so that differences of cells are numbers, too.
int cellOf(double position, double cell) {
  constexpr double far = 1e9;
  const double number = std::floor(position / cell);
  if (!(number > -far)) return static_cast<int>(-far);
  return static_cast<int>(std::min(number, far));
}

}  // namespace

cv::Point FloorCells::at(double x, double y) const {
  return {cellOf(x, cell_) - extent_.x, cellOf(y, cell_) - extent_.y};
}

cv::Point2d FloorCells::centerOf(cv::Point cell) const {
  return {(cell.x + extent_.x + 0.5) * cell_, (cell.y + extent_.y + 0.5) * cell_};
}

cv::Vec4i FloorCells::cover(double x, double y, double radius) {
  const double limit = 1e8 * cell_;  // cells are counted by int
  if (!(std::abs(x) + radius < limit && std::abs(y) + radius < limit))
    fail(ErrorCode::tooLarge, "a view at ({:.0f}, {:.0f}) m is too far from the origin; check the poses", x,
         y);
  const cv::Point from(cellOf(x - radius, cell_), cellOf(y - radius, cell_));
  const cv::Point to(cellOf(x + radius, cell_) + 1, cellOf(y + radius, cell_) + 1);
  const cv::Rect wanted = extent_.empty() ? cv::Rect(from, to) : extent_ | cv::Rect(from, to);
  if (static_cast<double>(wanted.width) * wanted.height > maxCells)
    fail(
        ErrorCode::tooLarge,
        "the views span {:.0f} × {:.0f} m, more than a grid of cells of {} m holds; check the poses, or give "
        "larger cells",
        wanted.width * cell_, wanted.height * cell_, cell_);
  const cv::Vec4i border(extent_.x - wanted.x, extent_.y - wanted.y, wanted.br().x - extent_.br().x,
                         wanted.br().y - extent_.br().y);
  const bool first = extent_.empty();
  extent_ = wanted;
  return first ? cv::Vec4i(0, 0, wanted.width, wanted.height) : border;
}

cv::Mat grown(const cv::Mat& image, const cv::Vec4i& border) {
  if (border == cv::Vec4i()) return image;
  cv::Mat result(image.rows + border[1] + border[3], image.cols + border[0] + border[2], image.type(),
                 cv::Scalar::all(0));
  if (!image.empty()) image.copyTo(result(cv::Rect(border[0], border[1], image.cols, image.rows)));
  return result;
}

}  // namespace estancia
