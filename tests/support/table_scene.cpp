// SPDX-License-Identifier: Apache-2.0
#include "support/table_scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <opencv2/core/affine.hpp>
#include <optional>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "support/written_drive.hpp"

namespace estancia::test {
namespace {

const CameraIntrinsics camera{320, 240, 262.5, 262.5, 159.5, 119.5};
const cv::Vec3b tableColor{150, 150, 150};

/// How far along the ray, if at all.
std::optional<double> hit(const Solid& solid, const cv::Vec3d& from, const cv::Vec3d& ray) {
  const cv::Vec3d to = from - solid.center;
  if (solid.kind == Solid::Kind::ball) {
    const double a = ray.dot(ray), b = to.dot(ray), c = to.dot(to) - solid.half[0] * solid.half[0];
    const double root = b * b - a * c;
    return root < 0 ? std::nullopt : std::optional((-b - std::sqrt(root)) / a);
  }
  double near = 0, far = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = (-solid.half[axis] - to[axis]) / ray[axis],
                 high = (solid.half[axis] - to[axis]) / ray[axis];
    near = std::max(near, std::min(low, high));
    far = std::min(far, std::max(low, high));
  }
  return near <= far ? std::optional(near) : std::nullopt;
}

/// From 0.9 m away, 40° above the table.
Pose poseAround(double degrees) {
  const double azimuth = degrees * CV_PI / 180, elevation = 40 * CV_PI / 180;
  const cv::Vec3d back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                       std::sin(elevation));
  const cv::Vec3d z = -back, x = cv::normalize(z.cross(cv::Vec3d(0, 0, 1))), y = z.cross(x);
  const cv::Matx33d rotation(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
  return poseOf(cv::Affine3d(rotation, 0.9 * back + cv::Vec3d(0, 0, 0.05)));
}

std::pair<cv::Mat, cv::Mat> look(const std::vector<Solid>& solids, const Pose& pose, bool table) {
  const cv::Affine3d rigid = rigidOf(pose);
  const cv::Vec3d from = rigid.translation();
  std::pair<cv::Mat, cv::Mat> seen{cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0)),
                                   cv::Mat(240, 320, CV_32F, cv::Scalar::all(0))};
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const cv::Vec3d ray = rigid.rotation() * cv::Vec3d(camera.slopeX(u), camera.slopeY(v), 1);
      double nearest = table && ray[2] < 0 ? -from[2] / ray[2] : std::numeric_limits<double>::infinity();
      cv::Vec3b color = tableColor;
      for (const Solid& solid : solids)
        if (const auto along = hit(solid, from, ray); along && *along < nearest) {
          nearest = *along;
          color = solid.bgr;
        }
      if (!(nearest < 5)) continue;
      seen.first.at<cv::Vec3b>(v, u) = color;
      seen.second.at<float>(v, u) = static_cast<float>(nearest);  // the ray's z is 1 in the camera
    }
  return seen;
}

}  // namespace

Solid ballAt(double x, double y, double radius, const cv::Vec3b& bgr) {
  return {Solid::Kind::ball, {x, y, radius}, {radius, radius, radius}, bgr};
}

Solid boxAt(double x, double y, const cv::Vec3d& half, const cv::Vec3b& bgr) {
  return {Solid::Kind::box, {x, y, half[2]}, half, bgr};
}

TableSequence::TableSequence(const std::vector<Solid>& solids, const std::vector<double>& degrees,
                             bool table) {
  intrinsics_ = camera;
  for (const double angle : degrees) {
    Frame& frame = frames_.emplace_back();
    frame.name = fmt::format("{:04}.png", frames_.size() - 1);
    frame.pose = poseAround(angle);
    seen_.push_back(look(solids, *frame.pose, table));
  }
}

cv::Mat TableSequence::depth(std::size_t i) const {
  if (seen_.at(i).second.empty()) throw Error(ErrorCode::fileUnreadable, frames_[i].name + " has no depth");
  return seen_[i].second;
}

void TableSequence::losePoses() {
  for (Frame& frame : frames_) frame.pose.reset();
}

void TableSequence::dim(double factor) {
  for (auto& [image, depth] : seen_) image *= factor;
}

void TableSequence::writeTo(const std::filesystem::path& folder) const {
  writeDrive(*this, folder);
}

}  // namespace estancia::test
