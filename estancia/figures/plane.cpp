// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/plane.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace estancia::report {
namespace {

using Position = std::array<double, 3>;

Position positionOf(const Pose& pose) {
  return {pose.x, pose.y, pose.z};
}

double dot(const Position& a, const Position& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Position cross(const Position& a, const Position& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

cv::Matx33d covariance(const std::vector<Position>& positions) {
  Position mean{};
  for (const Position& p : positions)
    for (std::size_t i = 0; i < 3; ++i) mean[i] += p[i] / static_cast<double>(positions.size());
  cv::Matx33d sum = cv::Matx33d::zeros();
  for (const Position& p : positions)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum(i, j) += (p[static_cast<std::size_t>(i)] - mean[static_cast<std::size_t>(i)]) *
                     (p[static_cast<std::size_t>(j)] - mean[static_cast<std::size_t>(j)]);
  return sum;
}

}  // namespace

Point GroundPlane::project(const Position& position) const {
  return {dot(position, right), dot(position, up)};
}

GroundPlane planeOf(const std::vector<Position>& positions) {
  if (positions.empty()) return {};
  const cv::Matx33d spread = covariance(positions);
  const std::array<double, 3> variance{spread(0, 0), spread(1, 1), spread(2, 2)};
  const double least = *std::min_element(variance.begin(), variance.end());
  std::array<double, 3> sorted = variance;
  std::sort(sorted.begin(), sorted.end());
  // "clearly least": half the standard deviation of the next axis, or nothing to choose between at all
  if (sorted[0] <= 0.25 * sorted[1] || sorted[1] == 0) {
    if (variance[2] == least) return {};
    if (variance[1] == least) return {{1, 0, 0}, {0, 0, 1}};
    return {{0, 1, 0}, {0, 0, 1}};
  }
  cv::Mat values, vectors;  // rows of eigenvectors, largest first
  cv::eigen(cv::Mat(spread), values, vectors);
  const auto axis = [&vectors](int row) {
    return Position{vectors.at<double>(row, 0), vectors.at<double>(row, 1), vectors.at<double>(row, 2)};
  };
  // The signs of eigenvectors are arbitrary: right points along its largest component, and the viewer is
  // above the plane (+z; −y in a camera's frame) so that the map is not mirrored.
  Position right = axis(0), normal = axis(2);
  const auto largest = [](const Position& v) {
    return *std::max_element(v.begin(), v.end(),
                             [](double a, double b) { return std::abs(a) < std::abs(b); });
  };
  const auto flip = [](Position& v) {
    for (double& value : v) value = -value;
  };
  if (largest(right) < 0) flip(right);
  const double height = largest(normal) == normal[1] ? -normal[1] : largest(normal);
  if (height < 0) flip(normal);
  return {right, cross(normal, right)};
}

DrivenPath projectPath(std::span<const std::optional<Pose>> poses, bool fromAbove) {
  std::vector<Position> positions;
  for (const auto& pose : poses)
    if (pose && pose->isPlausible()) positions.push_back(positionOf(*pose));
  DrivenPath path;
  path.empty = positions.empty();
  if (path.empty) return path;
  if (!fromAbove) path.plane = planeOf(positions);
  path.points.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses[i] && poses[i]->isPlausible()) path.points[i] = path.plane.project(positionOf(*poses[i]));
  return path;
}

}  // namespace estancia::report
