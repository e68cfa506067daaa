// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/cloud_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr float nothing = std::numeric_limits<float>::infinity();
const cv::Vec3b background(250, 248, 246), plainGray(176, 172, 168);

double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<cv::Vec3d> finitePoints(const CloudLayer& layer) {
  std::vector<cv::Vec3d> points;
  for (const cv::Point3f& p : layer.cloud->points)
    if (isFinite(p)) points.push_back(layer.pose * cv::Vec3d(p.x, p.y, p.z));
  return points;
}

/// Where the image is taken from.
struct Camera {
  cv::Affine3d fromScene;
  double focal = 1;
  cv::Point2d center;

  cv::Point3d project(const cv::Vec3d& p) const {  // x, y [pixels], z: distance along the view
    const cv::Vec3d c = fromScene * p;
    return {focal * c[0] / c[2] + center.x, focal * c[1] / c[2] + center.y, c[2]};
  }
};

/// Stands where the sensor stood, or far enough from clouds that lie around the origin, then walks around.
Camera placeCamera(const std::vector<cv::Vec3d>& points, const CloudView& view) {
  cv::Vec3d center;
  std::vector<double> distances;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const cv::Vec3d& p : points) values.push_back(p[axis]);
    center[axis] = (quantile(values, 0.02) + quantile(values, 0.98)) / 2;
  }
  for (const cv::Vec3d& p : points) distances.push_back(cv::norm(p - center));
  const double radius = std::max(quantile(distances, 0.98), 1e-9);
  const double away = std::max(cv::norm(center), 2 * radius);
  const cv::Vec3d forward =
      cv::norm(center) > 1.2 * radius ? center * (1 / cv::norm(center)) : cv::Vec3d(0, 0, 1);

  const double turn = view.azimuth * std::numbers::pi / 180, rise = view.elevation * std::numbers::pi / 180;
  const cv::Vec3d down(0, 1, 0);
  cv::Vec3d right = down.cross(forward);
  right = cv::norm(right) > 1e-6 ? right * (1 / cv::norm(right)) : cv::Vec3d(1, 0, 0);
  const cv::Affine3d around(down * -turn), over(right * -rise);
  const cv::Vec3d z = around.rotation() * (over.rotation() * forward);
  const cv::Vec3d x = around.rotation() * right, y = z.cross(x);
  const cv::Vec3d eye = center - away * z;
  const cv::Matx33d rotation(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]);

  Camera camera{cv::Affine3d(rotation, -(rotation * eye)), 1, {view.width / 2.0, view.height / 2.0}};
  std::vector<double> wide, high;
  for (const cv::Vec3d& p : points) {
    const cv::Vec3d c = camera.fromScene * p;
    if (c[2] <= 0) continue;
    wide.push_back(std::abs(c[0] / c[2]));
    high.push_back(std::abs(c[1] / c[2]));
  }
  if (!wide.empty())
    camera.focal = 0.94 * std::min(camera.center.x / std::max(quantile(wide, 0.995), 1e-9),
                                   camera.center.y / std::max(quantile(high, 0.995), 1e-9));
  return camera;
}

struct Canvas {
  cv::Mat color, distance;

  void dot(const cv::Point3d& at, int half, const cv::Vec3b& bgr) {
    const int left = static_cast<int>(std::lround(at.x)), top = static_cast<int>(std::lround(at.y));
    for (int y = std::max(top - half, 0); y <= std::min(top + half, color.rows - 1); ++y)
      for (int x = std::max(left - half, 0); x <= std::min(left + half, color.cols - 1); ++x) {
        if ((x - left) * (x - left) + (y - top) * (y - top) > half * half + half) continue;
        float& z = distance.at<float>(y, x);
        if (static_cast<float>(at.z) >= z) continue;
        z = static_cast<float>(at.z);
        color.at<cv::Vec3b>(y, x) = bgr;
      }
  }
};

bool isNear(const cv::Point3d& p, const Canvas& canvas) {
  return p.z > 0 && p.x > -64 && p.y > -64 && p.x < canvas.color.cols + 64 && p.y < canvas.color.rows + 64;
}

void draw(const CloudLayer& layer, double nearer, const Camera& camera, Canvas& canvas) {
  const PointCloud& cloud = *layer.cloud;
  const double spacing = resolutionOf(cloud);
  const auto colorOf = [&](std::size_t i) {
    return layer.color ? *layer.color : cloud.colors.empty() ? plainGray : cloud.colors[i];
  };
  const auto place = [&](std::size_t i) {
    const cv::Point3f& p = cloud.points[i];
    return camera.project(layer.pose * cv::Vec3d(p.x, p.y, p.z)) - cv::Point3d(0, 0, nearer);
  };
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!isFinite(cloud.points[i])) continue;
    const cv::Point3d at = place(i);
    if (!isNear(at, canvas)) continue;
    const double size = layer.edges.empty() ? 0.75 * spacing * camera.focal / at.z : 1;
    canvas.dot(at, static_cast<int>(std::clamp(size, 1.0, 8.0)), colorOf(i));
  }
  for (const auto& [from, to] : layer.edges) {
    if (from >= cloud.points.size() || to >= cloud.points.size()) continue;
    const cv::Point3d a = place(from), b = place(to);
    if (!isNear(a, canvas) || !isNear(b, canvas)) continue;
    const auto steps = static_cast<int>(std::hypot(b.x - a.x, b.y - a.y)) + 1;
    for (int s = 0; s <= steps; ++s)
      canvas.dot(a + (b - a) * (static_cast<double>(s) / steps), 0, colorOf(from));
  }
}

/// A pixel darkens by how much nearer those around it are.
void shade(Canvas& canvas) {
  constexpr int reach = 2;
  const cv::Mat flat = canvas.color.clone();
  for (int y = 0; y < flat.rows; ++y)
    for (int x = 0; x < flat.cols; ++x) {
      const float z = canvas.distance.at<float>(y, x);
      if (z == nothing) continue;
      double hidden = 0;
      for (int dy = -reach; dy <= reach; dy += reach)
        for (int dx = -reach; dx <= reach; dx += reach) {
          const int u = x + dx, v = y + dy;
          if (u < 0 || v < 0 || u >= flat.cols || v >= flat.rows) continue;
          const float other = canvas.distance.at<float>(v, u);
          if (other != nothing) hidden += std::max(0.0, std::log(static_cast<double>(z) / other));
        }
      const double light = std::max(0.25, std::exp(-60.0 * hidden / 8));
      for (int c = 0; c < 3; ++c)
        canvas.color.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(light * flat.at<cv::Vec3b>(y, x)[c]);
    }
}

}  // namespace

cv::Mat drawClouds(std::span<const CloudLayer> layers, const CloudView& view) {
  if (view.width < 16 || view.height < 16 || view.width > 16384 || view.height > 16384)
    fail(ErrorCode::invalidOption, "an image of {} × {} pixels cannot be drawn; use 16 to 16384", view.width,
         view.height);
  const std::vector<cv::Vec3d> points =
      layers.empty() ? std::vector<cv::Vec3d>{} : finitePoints(layers.front());
  if (points.empty()) throw Error(ErrorCode::invalidInput, "no finite point to draw; give a cloud with some");

  const Camera camera = placeCamera(points, view);
  Canvas canvas{cv::Mat(view.height, view.width, CV_8UC3, cv::Scalar(background)),
                cv::Mat(view.height, view.width, CV_32F, cv::Scalar(nothing))};
  // Points on the first layer, within two of its spacings and its noise, are drawn over it.
  double nearer = 0;
  if (layers.size() > 1) {
    const Neighbors around(layers.front().cloud->points, 0);
    nearer = 2 * resolutionOf(around) + 3 * estimateNoise(around);
  }
  for (const CloudLayer& layer : layers) draw(layer, &layer == layers.data() ? 0 : nearer, camera, canvas);
  shade(canvas);
  return canvas.color;
}

}  // namespace estancia
