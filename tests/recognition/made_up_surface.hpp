// Surfaces to describe, made up with seeds; and how far a found pose is from the true one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core/affine.hpp>
#include <random>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia::test {

/// A wavy sheet of about `side`² points over `size` × `size` meters with true normals, slightly rough.
inline PointCloud wavySheet(int side, double size, std::uint32_t seed = 1, double rough = 0.0005) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  PointCloud cloud;
  for (int i = 0; i < side * side; ++i) {
    const double x = uniform() * size, y = uniform() * size, k = 8 / size;
    const double z =
        size * (0.10 * std::sin(k * x) * std::cos(1.3 * k * y) + 0.05 * std::sin(2.1 * k * (x + 0.4 * y)));
    const double dx =
        size * k *
        (0.10 * std::cos(k * x) * std::cos(1.3 * k * y) + 0.105 * std::cos(2.1 * k * (x + 0.4 * y)));
    const double dy =
        size * k *
        (-0.13 * std::sin(k * x) * std::sin(1.3 * k * y) + 0.042 * std::cos(2.1 * k * (x + 0.4 * y)));
    cv::Vec3d n(dx, dy, -1);
    n *= 1 / cv::norm(n);
    const cv::Vec3d p(x - size / 2, y - size / 2, z + 3 * size + rough * size * (uniform() - 0.5));
    cloud.points.emplace_back(
        cv::Point3f(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])));
    cloud.normals.emplace_back(
        cv::Point3f(static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// The cloud with stripes and a slope of color.
inline PointCloud painted(PointCloud cloud) {
  for (const cv::Point3f& p : cloud.points) {
    const bool stripe = std::sin(300 * p.x) > 0;
    cloud.colors.emplace_back(cv::saturate_cast<uchar>(stripe ? 30 : 180),
                              cv::saturate_cast<uchar>(120 + 300 * p.y), stripe ? 210 : 60);
  }
  return cloud;
}

inline std::vector<std::uint32_t> everyNth(const Surface& surface, std::uint32_t n) {
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < surface.size(); i += n) chosen.push_back(i);
  return chosen;
}

inline PointCloud moved(const PointCloud& cloud, const cv::Affine3d& by) {
  PointCloud there = cloud;
  for (cv::Point3f& p : there.points) p = cv::Affine3f(by) * p;
  for (cv::Point3f& n : there.normals) n = cv::Affine3f(by).rotation() * n;
  return there;
}

struct PoseError {
  /// Distance between the model's centers [m].
  double translation = 0;
  /// [degrees], 0 … 180
  double rotation = 0;
};

/// The center of the bounding box of a cloud's finite points [m].
inline cv::Point3d centerOf(const PointCloud& model) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  cv::Point3f low(infinity, infinity, infinity), high = -low;
  for (const cv::Point3f& p : model.points) {
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return (cv::Point3d(low) + cv::Point3d(high)) / 2;
}

/// Between two T_scene_model of a model with this center.
inline PoseError poseError(const cv::Affine3d& found, const cv::Affine3d& truth, const cv::Point3d& center) {
  return {cv::norm(found * center - truth * center), angleOf(found.inv() * truth) * 180 / std::numbers::pi};
}

/// Whether the error is at most 0.02 m and 15°.
inline bool isCorrect(const PoseError& error) {
  return error.translation <= 0.02 && error.rotation <= 15;
}

}  // namespace estancia::test
