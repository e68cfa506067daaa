// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {
namespace {

/// A pixel of a column, on the floor.
struct Seen {
  cv::Point2d at;
  double range = 0, height = 0;
};

/// Where the view along one column ends.
struct End {
  cv::Point2d at;
  bool isWall = false;
};

/// An upright surface spans at least so much of height [m]: more than a step or the front of a drawer.
constexpr double uprightHeight = 0.2;
/// The farthest of the pixels are left out as outliers: mixed pixels at edges, noise.
constexpr double outliers = 0.05;
/// Three standard deviations of a structured-light camera, σ = 0.0012 z² (Khoshelham and Elberink 2012).
double uncertaintyAt(double range) {
  return 3 * 0.0012 * range * range;
}

std::optional<End> endOf(std::vector<Seen>& column, double cell) {
  constexpr std::size_t few = 5;
  if (column.size() < few) return std::nullopt;
  const auto rank = static_cast<std::size_t>((1 - outliers) * static_cast<double>(column.size() - 1));
  const auto end = column.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(column.begin(), end, column.end(),
                   [](const Seen& a, const Seen& b) { return a.range < b.range; });
  const Seen farthest = *end;
  const double tolerance = cell + uncertaintyAt(farthest.range);
  double lowest = farthest.height, highest = farthest.height;
  for (const Seen& seen : column)
    if (std::abs(seen.range - farthest.range) < tolerance) {
      lowest = std::min(lowest, seen.height);
      highest = std::max(highest, seen.height);
    }
  return End{farthest.at, highest - lowest > uprightHeight};
}

/// The ends of all columns that see anything, from left to right.
std::vector<std::optional<End>> endsOf(const cv::Mat& depth, const CameraIntrinsics& camera,
                                       const cv::Affine3d& pose, const Floor& floor, double cell) {
  const int step = std::max(1, depth.cols / 160);  // a third of a degree is fine enough
  const auto here = floor.position(pose.translation());
  std::vector<std::optional<End>> ends;
  std::vector<Seen> column;
  for (int u = 0; u < depth.cols; u += step) {
    column.clear();
    for (int v = 0; v < depth.rows; v += step) {
      const double z = depth.at<float>(v, u);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const cv::Vec3d point = pose * cv::Vec3d(camera.slopeX(u) * z, camera.slopeY(v) * z, z);
      const auto there = floor.position(point);
      column.push_back({there, cv::norm(there - here), floor.height(point)});
    }
    ends.push_back(endOf(column, cell));
  }
  return ends;
}

/// The image with a border of so many empty cells, as FloorCells::cover() returns.
cv::Mat grown(const cv::Mat& image, const cv::Vec4i& border) {
  if (border == cv::Vec4i()) return image;
  cv::Mat result(image.rows + border[1] + border[3], image.cols + border[0] + border[2], image.type(),
                 cv::Scalar::all(0));
  if (!image.empty()) image.copyTo(result(cv::Rect(border[0], border[1], image.cols, image.rows)));
  return result;
}

}  // namespace

void OccupancyGrid::add(const cv::Mat& depth, const CameraIntrinsics& camera, const Pose& pose) {
  const cv::Affine3d rigid = rigidOf(pose);
  const cv::Point2d here = floor_.position(rigid.translation());
  const auto ends = endsOf(depth, camera.scaledTo(depth.cols, depth.rows), rigid, floor_, cells_.cell());
  double reach = 0;
  for (const auto& end : ends)
    if (end) reach = std::max(reach, cv::norm(end->at - here));
  if (reach == 0) return;
  const cv::Vec4i border = cells_.cover(here.x, here.y, reach + cells_.cell());
  if (free_.empty()) free_ = cv::Mat(0, 0, CV_32S), hits_ = cv::Mat(0, 0, CV_32S);
  free_ = grown(free_, border);
  hits_ = grown(hits_, border);
  // A fan from the camera over all ends; where a column sees nothing it closes at the camera.
  std::vector<cv::Point> fan{cells_.at(here.x, here.y)};
  for (const auto& end : ends) {
    fan.push_back(end ? cells_.at(end->at.x, end->at.y) : fan.front());
    if (end && end->isWall) ++hits_.at<int>(fan.back());
  }
  const cv::Rect box = cv::boundingRect(fan);
  cv::Mat seen(box.size(), CV_8U, cv::Scalar(0));
  cv::fillPoly(seen, std::vector{fan}, cv::Scalar(1), cv::LINE_8, 0, -box.tl());
  cv::add(free_(box), seen, free_(box), cv::noArray(), CV_32S);
}

bool OccupancyGrid::isWall(int row, int column) const {
  // A free cell beside a wall ends a view now and then; a wall is seen through hardly ever.
  constexpr double share = 0.3;
  const int hits = hits_.at<int>(row, column), free = free_.at<int>(row, column);
  return hits > 1 ? hits > share * free : hits == 1 && free <= 1;
}

cv::Mat OccupancyGrid::freeSpace() const {
  cv::Mat space(cells_.rows(), cells_.columns(), CV_8U, cv::Scalar(0));
  for (int row = 0; row < space.rows; ++row)
    for (int column = 0; column < space.cols; ++column)
      if (free_.at<int>(row, column) > 0 && !isWall(row, column)) space.at<unsigned char>(row, column) = 255;
  return space;
}

cv::Mat OccupancyGrid::walls() const {
  cv::Mat walls(cells_.rows(), cells_.columns(), CV_8U, cv::Scalar(0));
  for (int row = 0; row < walls.rows; ++row)
    for (int column = 0; column < walls.cols; ++column)
      if (isWall(row, column)) walls.at<unsigned char>(row, column) = 255;
  return walls;
}

}  // namespace estancia
