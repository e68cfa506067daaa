// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/known_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/cloud/resolution.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/prepared.hpp"
#include "estancia/world_file/observation.hpp"

namespace estancia {
namespace {

constexpr double smallestThing = 0.02, largestThing = 10;  // [m]
constexpr double nearest = 0.05;                           // [m] from the camera
/// Number of cells of the size of a point by which a model is measured.
constexpr double cellsAcross = 128;

/// One point of each cell of this width.
std::vector<cv::Point3f> knownPointsBy(const PointCloud& cloud, double cell) {
  std::set<std::array<std::int32_t, 3>> taken;
  std::vector<cv::Point3f> points;
  const auto number = [cell](float x) {
    return static_cast<std::int32_t>(std::floor(static_cast<double>(x) / cell));
  };
  for (const cv::Point3f& p : cloud.points)
    if (isFinite(p) && taken.insert({number(p.x), number(p.y), number(p.z)}).second) points.push_back(p);
  return points;
}

/// Deviations that are no contradiction [m]: a model's surface width, and three errors of a Kinect's depth.
double agreementAt(double depth, double extent) {
  return std::clamp(extent / 40, 0.005, 0.015) + 0.0036 * depth * depth;
}

}  // namespace

KnownObjects::KnownObjects(const std::vector<ModelFile>& files) {
  for (const ModelFile& file : files) {
    if (std::ranges::find(models_, file.name, &Model::name) != models_.end())
      fail(ErrorCode::invalidOption, "two objects are called {}; name them NAME=FILE", file.name);
    const PointCloud cloud = readCloud(file.cloud, {.unit = file.unit});
    Model model{file.name, sha256OfFile(file.cloud) + (file.unit == "m" ? "" : " " + file.unit)};
    const std::string said = file.cloud.string();
    model.prepared = recognizer_.prepareModel(said, cloud);
    model.extent = model.prepared->extent();
    if (!(model.extent >= smallestThing && model.extent <= largestThing))
      fail(ErrorCode::invalidInput,
           "{} measures {:.4g} m; known objects measure {} to {} m: give its unit, --object-unit mm or cm",
           said, model.extent, smallestThing, largestThing);
    recognizer_.find(*model.prepared, *recognizer_.prepareScene(said, cloud));
    model.spacing = std::max(model.extent / cellsAcross, resolutionOf(cloud));
    model.points = knownPointsBy(cloud, model.spacing);
    models_.push_back(std::move(model));
  }
}

std::vector<cv::Affine3d> KnownObjects::find(const Model& model, const cv::Mat& depth, const cv::Mat& segment,
                                             const CameraIntrinsics& camera) const {
  const PointCloud cloud = segmentCloud(depth, segment, camera);
  std::vector<std::pair<double, cv::Affine3d>> found;
  try {
    const auto scene = recognizer_.prepareScene("a segment", cloud);
    for (const PoseHypothesis& h : recognizer_.search(*model.prepared, *scene).poses) {
      const cv::Affine3d pose = scene->fromView() * h.pose;
      found.emplace_back(agreementIn(model, pose, depth, segment, camera).fit(), pose);
    }
  } catch (const Error& e) {
    if (e.code() != ErrorCode::mismatch && e.code() != ErrorCode::invalidInput &&
        e.code() != ErrorCode::insufficientData)
      throw;  // these two: the segment is too small, or has no extent
  }
  std::ranges::stable_sort(found, std::ranges::greater{}, [](const auto& f) { return f.first; });
  std::vector<cv::Affine3d> poses;
  for (const auto& [fit, pose] : found) poses.push_back(pose);
  return poses;
}

namespace {

/// The model's depth in each pixel, infinite where it is not.
cv::Mat_<float> drawn(const KnownObjects::Model& model, const cv::Affine3d& pose, const cv::Size& size,
                      const CameraIntrinsics& camera) {
  constexpr float none = std::numeric_limits<float>::infinity();
  constexpr double widest = 20;  // pixels from the middle of a point to its edge
  cv::Mat_<float> depths(size, none);
  const cv::Rect image({}, size);
  for (const cv::Point3f& point : model.points) {
    const cv::Point3d p = pose * cv::Point3d(point);
    if (p.z < nearest) continue;
    const double u = camera.fx * p.x / p.z + camera.cx, v = camera.fy * p.y / p.z + camera.cy,
                 half = std::min(widest, 0.6 * model.spacing * camera.fx / p.z);
    if (!(u > -widest && v > -widest && u < size.width + widest && v < size.height + widest)) continue;
    const cv::Point from(static_cast<int>(std::lround(u - half)), static_cast<int>(std::lround(v - half))),
        to(static_cast<int>(std::lround(u + half)) + 1, static_cast<int>(std::lround(v + half)) + 1);
    const cv::Rect square = cv::Rect(from, to) & image;
    for (int y = square.y; y < square.br().y; ++y)
      for (int x = square.x; x < square.br().x; ++x) {
        float& z = depths(y, x);
        z = std::min(z, static_cast<float>(p.z));
      }
  }
  return depths;
}

}  // namespace

ViewAgreement agreementIn(const KnownObjects::Model& model, const cv::Affine3d& pose, const cv::Mat& depth,
                          const cv::Mat& segment, const CameraIntrinsics& camera,
                          std::vector<std::uint8_t>* seen) {
  const cv::Mat_<float> expectedAt = drawn(model, pose, depth.size(), camera);
  const cv::Rect image({}, depth.size());
  if (seen != nullptr)
    for (std::size_t i = 0; i < model.points.size(); ++i) {
      const cv::Point3d p = pose * cv::Point3d(model.points[i]);
      if (p.z < nearest) continue;
      const cv::Point at(static_cast<int>(std::lround(camera.fx * p.x / p.z + camera.cx)),
                         static_cast<int>(std::lround(camera.fy * p.y / p.z + camera.cy)));
      if (!image.contains(at)) continue;
      if (std::abs(static_cast<double>(depth.at<float>(at)) - p.z) < agreementAt(p.z, model.extent))
        (*seen)[i] = 1;
    }
  cv::Mat core;
  cv::erode(expectedAt < std::numeric_limits<float>::infinity(), core, cv::Mat());
  ViewAgreement agreement;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const bool inside = segment.at<std::uint8_t>(v, u) != 0;
      agreement.segment += inside;
      const double z = depth.at<float>(v, u), expected = expectedAt(v, u);
      if (!std::isfinite(expected) || !(z > 0)) continue;
      if (std::abs(z - expected) < agreementAt(z, model.extent)) {
        ++agreement.same;
        agreement.inside += inside;
      } else {
        agreement.before += z > expected && core.at<std::uint8_t>(v, u) != 0;
      }
    }
  return agreement;
}

}  // namespace estancia
