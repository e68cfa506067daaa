// Scenes of a few shapes, as a depth camera sees them, with what belongs to which.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia::test {

/// How far along origin + t · ray something is (of several hits the nearest), or infinity. Meters, z up.
using Shape = std::function<double(const cv::Vec3d& origin, const cv::Vec3d& ray)>;

inline constexpr double never = HUGE_VAL;

/// What of the plane through `at` lies within half · side of it, along two directions at right angles.
inline Shape board(const cv::Vec3d& at, const cv::Vec3d& along, const cv::Vec3d& up, double halfAlong,
                   double halfUp) {
  const cv::Vec3d normal = along.cross(up);
  return [=](const cv::Vec3d& origin, const cv::Vec3d& ray) {
    const double t = (at - origin).dot(normal) / ray.dot(normal);
    const cv::Vec3d d = origin + t * ray - at;
    const bool hit = t > 0 && std::abs(d.dot(along)) <= halfAlong && std::abs(d.dot(up)) <= halfUp;
    return hit ? t : never;
  };
}

inline Shape level(double height, double halfX = 50, double halfY = 50, double x = 0, double y = 0) {
  return board({x, y, height}, {1, 0, 0}, {0, 1, 0}, halfX, halfY);
}

/// A box that stands on `at`, turned by `angle` [rad] about its upright.
inline Shape box(const cv::Vec3d& at, const cv::Vec3d& size, double angle = 0) {
  const cv::Vec3d x(std::cos(angle), std::sin(angle), 0), y(-std::sin(angle), std::cos(angle), 0), z(0, 0, 1);
  const cv::Vec3d middle = at + z * (size[2] / 2);
  return [=](const cv::Vec3d& origin, const cv::Vec3d& ray) {
    double in = 0, out = never;
    const cv::Vec3d axes[] = {x, y, z};
    for (int k = 0; k < 3; ++k) {
      const double along = ray.dot(axes[k]), from = (middle - origin).dot(axes[k]);
      const double a = (from - size[k] / 2) / along, b = (from + size[k] / 2) / along;
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    return in > 0 && in <= out ? in : never;
  };
}

/// What of a sphere lies below `rim`: a bowl; all of it where the rim is high enough.
inline Shape bowl(const cv::Vec3d& middle, double radius, double rim) {
  return [=](const cv::Vec3d& origin, const cv::Vec3d& ray) {
    const cv::Vec3d d = origin - middle;
    const double a = ray.dot(ray), b = d.dot(ray), c = d.dot(d) - radius * radius;
    const double root = std::sqrt(b * b - a * c);  // NaN beside it
    for (const double t : {(-b - root) / a, (-b + root) / a})
      if (t > 0 && origin[2] + t * ray[2] <= rim) return t;
    return never;
  };
}

struct View {
  CameraIntrinsics camera{640, 480, 525, 525, 319.5, 239.5};
  cv::Vec3d from{0, -0.75, 0.6}, to{0, 0, 0.05};
  double noise = 0.0014;  ///< noise of 1/z [1/m]: so many meters at 1 m
  double roll = 0;        ///< roll of the camera about its axis, clockwise [rad]
};

struct Seen {
  cv::Mat depth;        ///< CV_32F [m], 0: none
  cv::Mat shape;        ///< CV_32S, the number of the shape; -1: none
  cv::Matx33d toScene;  ///< directions in the camera → in the scene
};

inline Seen see(const std::vector<Shape>& shapes, const View& view = {}) {
  const cv::Vec3d forward = cv::normalize(view.to - view.from),
                  across = cv::normalize(forward.cross(cv::Vec3d(0, 0, 1))), below = forward.cross(across),
                  right = std::cos(view.roll) * across + std::sin(view.roll) * below,
                  down = std::cos(view.roll) * below - std::sin(view.roll) * across;
  const CameraIntrinsics& camera = view.camera;
  Seen seen{cv::Mat(camera.height, camera.width, CV_32F, cv::Scalar(0)),
            cv::Mat(camera.height, camera.width, CV_32S, cv::Scalar(-1)),
            {right[0], down[0], forward[0], right[1], down[1], forward[1], right[2], down[2], forward[2]}};
  cv::RNG random(7);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const cv::Vec3d ray = forward + camera.slopeX(u) * right + camera.slopeY(v) * down;
      double nearest = never;
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        const double t = shapes[i](view.from, ray);
        if (!(t < nearest)) continue;
        nearest = t;
        seen.shape.at<int>(v, u) = static_cast<int>(i);
      }
      if (nearest < never)
        seen.depth.at<float>(v, u) = static_cast<float>(1 / (1 / nearest + random.gaussian(view.noise)));
    }
  return seen;
}

}  // namespace estancia::test
