// SPDX-License-Identifier: Apache-2.0
#include "recognition/made_up_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <utility>

namespace estancia::experiments {
namespace {

constexpr auto box = Solid::Shape::box, cylinder = Solid::Shape::cylinder,
               ellipsoid = Solid::Shape::ellipsoid;

Solid solidOf(Solid::Shape shape, const cv::Vec3d& size, const cv::Vec3d& at = {}) {
  return {shape, at, size, 0};
}

/// A foot under a wide disc.
std::vector<Solid> plateOf(double wide) {
  return {solidOf(cylinder, {0.6 * wide, 0.6 * wide, 0.012}),
          solidOf(cylinder, {wide, wide, 0.008}, {0, 0, 0.012})};
}

/// Four legs, a body, a head that looks to one side, a tail.
std::vector<Solid> toyOf(double high) {
  std::vector<Solid> toy;
  for (const double x : {-0.22, 0.22})
    for (const double y : {-0.12, 0.12})
      toy.push_back(solidOf(cylinder, cv::Vec3d(0.15, 0.15, 0.4) * high, cv::Vec3d(x, y, 0) * high));
  toy.push_back(solidOf(ellipsoid, cv::Vec3d(0.75, 0.45, 0.45) * high, cv::Vec3d(0, 0, 0.25) * high));
  toy.push_back(solidOf(ellipsoid, cv::Vec3d(0.4, 0.36, 0.42) * high, cv::Vec3d(0.36, 0.06, 0.58) * high));
  toy.push_back(solidOf(ellipsoid, cv::Vec3d(0.3, 0.1, 0.12) * high, cv::Vec3d(-0.42, 0, 0.5) * high));
  return toy;
}

std::vector<Solid> stoolOf(double wide, double high) {
  std::vector<Solid> stool{solidOf(box, {wide, wide, 0.04}, {0, 0, high - 0.04})};
  for (const double x : {-1., 1.})
    for (const double y : {-1., 1.})
      stool.push_back(solidOf(box, {0.035, 0.035, high - 0.04},
                              cv::Vec3d(x * (wide / 2 - 0.03), y * (wide / 2 - 0.03), 0)));
  return stool;
}

using Shape = std::pair<const char*, std::vector<Solid>>;

std::vector<Shape> shapes() {
  return {
      {"box", {solidOf(box, {0.16, 0.06, 0.21})}},
      {"box", {solidOf(box, {0.07, 0.07, 0.20})}},
      {"box", {solidOf(box, {0.30, 0.20, 0.20})}},
      {"book", {solidOf(box, {0.11, 0.018, 0.18})}},
      {"book", {solidOf(box, {0.15, 0.03, 0.22})}},
      {"book", {solidOf(box, {0.21, 0.04, 0.30})}},
      {"can", {solidOf(cylinder, {0.066, 0.066, 0.122})}},
      {"can", {solidOf(cylinder, {0.085, 0.085, 0.11})}},
      {"can", {solidOf(cylinder, {0.10, 0.10, 0.16})}},
      {"plate", plateOf(0.20)},
      {"plate", plateOf(0.26)},
      {"plate", plateOf(0.30)},
      {"toy", toyOf(0.12)},
      {"toy", toyOf(0.17)},
      {"toy", toyOf(0.24)},
      {"furniture", stoolOf(0.30, 0.35)},
      {"furniture", {solidOf(box, {0.45, 0.40, 0.18}), solidOf(box, {0.12, 0.03, 0.02}, {0, -0.21, 0.09})}},
      {"furniture", {solidOf(box, {0.60, 0.25, 0.02}), solidOf(box, {0.02, 0.25, 0.35}, {-0.29, 0, 0.02})}},
  };
}

PointCloud cloudOf(std::vector<cv::Point3f> points) {
  PointCloud cloud;
  cloud.width = points.size();
  cloud.height = 1;
  cloud.points = std::move(points);
  return cloud;
}

/// T_model_camera: a camera that looks at the middle of a thing of this height.
cv::Affine3d viewFrom(double turn, double pitch, double away, double height) {
  const cv::Vec3d middle(0, 0, height / 2),
      forward(-std::cos(pitch) * std::cos(turn), -std::cos(pitch) * std::sin(turn), -std::sin(pitch)),
      right = cv::normalize(forward.cross(cv::Vec3d(0, 0, 1))), down = forward.cross(right);
  return {cv::Matx33d(right[0], down[0], forward[0], right[1], down[1], forward[1], right[2], down[2],
                      forward[2]),
          middle - away * forward};
}

double heightOf(const std::vector<Solid>& solids) {
  double high = 0;
  for (const Solid& solid : solids) high = std::max(high, solid.at[2] + solid.size[2]);
  return high;
}

/// Pixels outside which none of the solids is seen.
cv::Rect windowOf(const std::vector<Solid>& solids, const cv::Affine3d& pose,
                  const CameraIntrinsics& camera) {
  const cv::Rect all(0, 0, camera.width, camera.height);
  cv::Point2d low(HUGE_VAL, HUGE_VAL), high = -low;
  for (const Solid& solid : solids)
    for (int corner = 0; corner < 8; ++corner) {
      const double wide = std::hypot(solid.size[0], solid.size[1]) / 2;
      const cv::Vec3d p =
          pose * (solid.at + cv::Vec3d((corner & 1) != 0 ? wide : -wide, (corner & 2) != 0 ? wide : -wide,
                                       (corner & 4) != 0 ? solid.size[2] : 0));
      if (!(p[2] > 0)) return all;
      const cv::Point2d at(p[0] / p[2] * camera.fx + camera.cx, p[1] / p[2] * camera.fy + camera.cy);
      low = {std::min(low.x, at.x), std::min(low.y, at.y)};
      high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    }
  const cv::Rect2d within = cv::Rect2d(low, high) & cv::Rect2d(all);
  return cv::Rect(cv::Point(static_cast<int>(within.x), static_cast<int>(within.y)),
                  cv::Point(static_cast<int>(std::ceil(within.br().x)),
                            static_cast<int>(std::ceil(within.br().y)))) &
         all;
}

void addOneSided(MadeUpModel& model, cv::RNG& random) {
  constexpr double noise = 0.0008, away = 1;  // [m]
  const CameraIntrinsics camera{640, 480, 525, 525, 319.5, 239.5};
  model.view = viewFrom(random.uniform(0.5, 1.1), random.uniform(0.45, 0.65), away, heightOf(model.solids));
  cv::Mat_<float> depth = renderSolids(model.solids, model.view.inv(), camera);
  for (float& z : depth)
    if (z > 0) z += static_cast<float>(random.gaussian(noise));
  model.oneSided = finitePoints(backProject(depth, camera));
}

}  // namespace

double MadeUpModel::diameter() const {
  cv::Vec3d low(HUGE_VAL, HUGE_VAL, HUGE_VAL), high = -low;
  for (const cv::Point3f& p : whole.points)
    for (int k = 0; k < 3; ++k) {
      const double c = static_cast<double>(cv::Vec3f(p)[k]);
      low[k] = std::min(low[k], c);
      high[k] = std::max(high[k], c);
    }
  return cv::norm(high - low);
}

cv::Mat renderSolids(const std::vector<Solid>& solids, const cv::Affine3d& pose,
                     const CameraIntrinsics& camera) {
  const cv::Matx33d back = pose.rotation().t();
  const cv::Vec3d from = back * -cv::Vec3d(pose.translation());
  cv::Mat_<float> depth(camera.height, camera.width, 0.F);
  const cv::Rect seen = windowOf(solids, pose, camera);
  for (int v = seen.y; v < seen.y + seen.height; ++v)
    for (int u = seen.x; u < seen.x + seen.width; ++u) {
      SolidHit hit;
      const cv::Vec3d ray = back * cv::Vec3d(camera.slopeX(u), camera.slopeY(v), 1);
      for (const Solid& solid : solids) cast(solid, from, ray, hit);
      if (std::isfinite(hit.t)) depth(v, u) = static_cast<float>(hit.t);
    }
  return depth;
}

std::vector<MadeUpModel> madeUpModels(std::uint64_t seed) {
  constexpr double step = 0.002;  // [m]
  cv::RNG random((seed + 1) * 0x9e3779b97f4a7c15ULL);
  std::vector<MadeUpModel> models;
  for (auto& [family, solids] : shapes()) {
    MadeUpModel model{{}, family, solids, cloudOf(surfaceOf(solids, step)), {}, {}};
    model.name = fmt::format("{} {:.0f} cm", family, 100 * model.diameter());
    addOneSided(model, random);
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace estancia::experiments
