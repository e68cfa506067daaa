// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/leveling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/core/bytes.hpp"

namespace estancia {
namespace {

constexpr double degree = std::numbers::pi / 180;
/// A camera is held upright by so much.
const double cosOfTilt = std::cos(45 * degree);
/// Limit of an area's weight: the far end of a wide plane is uncertain. [m²]
constexpr double maxArea = 4;
/// Minimum area of planes that distinguishes one direction from the others. [m²]
constexpr double minEvidence = 0.5;

/// A plane in the map.
struct MapFace {
  cv::Vec3d normal;
  double weight = 0;
  bool mayBeLevel = false;  // it faces up or down, as its camera saw it

  /// Whether it is level or upright within an angle of this sine and cosine, if `up` is up.
  bool isLevel(const cv::Vec3d& up, double cosine) const {
    return mayBeLevel && std::abs(normal.dot(up)) > cosine;
  }
  bool isUpright(const cv::Vec3d& up, double sine) const { return std::abs(normal.dot(up)) < sine; }
};

}  // namespace

void Leveling::add(std::size_t frame, std::span<const Plane> planes) {
  std::vector<Face>& faces = views_[frame];
  faces.clear();
  for (const Plane& plane : planes) faces.push_back({plane.normal, std::min(plane.area, maxArea)});
}

std::optional<cv::Vec3d> Leveling::up(std::span<const std::optional<Pose>> poses) const {
  std::vector<MapFace> faces;
  cv::Vec3d upright;
  for (const auto& [frame, seen] : views_) {
    if (frame >= poses.size() || !poses[frame]) continue;
    const cv::Matx33d rotation = rigidOf(*poses[frame]).rotation();
    const cv::Vec3d cameraUp = rotation * cv::Vec3d(0, -1, 0);
    upright += cameraUp;
    for (const Face& face : seen) {
      const cv::Vec3d normal = rotation * face.normal;
      faces.push_back({normal, face.weight, std::abs(normal.dot(cameraUp)) > cosOfTilt});
    }
  }
  if (faces.empty() || cv::norm(upright) < 1e-9) return std::nullopt;
  upright = cv::normalize(upright);

  // Candidates are the largest level planes, and what the largest walls have in common.
  constexpr std::size_t most = 32;
  std::ranges::stable_sort(faces, std::ranges::greater{}, &MapFace::weight);
  std::vector<cv::Vec3d> candidates, walls;
  for (const MapFace& face : faces)
    if (std::vector<cv::Vec3d>& kind = face.mayBeLevel ? candidates : walls; kind.size() < most)
      kind.push_back(face.normal);
  for (std::size_t i = 0; i < walls.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (const cv::Vec3d common = walls[i].cross(walls[j]); cv::norm(common) > 0.5)
        candidates.push_back(cv::normalize(common));
  std::optional<cv::Vec3d> best;
  double bestScore = 0;
  for (cv::Vec3d candidate : candidates) {
    constexpr double more = 1 + 1e-6;
    if (candidate.dot(upright) < 0) candidate = -candidate;
    if (candidate.dot(upright) < cosOfTilt) continue;
    double score = 0;
    for (const MapFace& face : faces)
      if (face.isLevel(candidate, std::cos(8 * degree)) || face.isUpright(candidate, std::sin(8 * degree)))
        score += face.weight;
    if (score > more * bestScore) bestScore = score, best = candidate;
  }
  if (!best) return std::nullopt;

  // The direction from which these planes are off least, in ever closer company.
  for (const double tolerance : {8 * degree, 4 * degree, 2 * degree, 2 * degree}) {
    cv::Matx33d off = cv::Matx33d::zeros();
    for (const MapFace& face : faces) {
      const cv::Matx33d along = face.weight * (face.normal * face.normal.t());
      if (face.isLevel(*best, std::cos(tolerance)))
        off += face.weight * cv::Matx33d::eye() - along;
      else if (face.isUpright(*best, std::sin(tolerance)))
        off += along;
    }
    cv::Mat values, vectors;  // largest first
    cv::eigen(cv::Mat(off), values, vectors);
    if (values.at<double>(1) - values.at<double>(2) < minEvidence) return std::nullopt;
    cv::Vec3d next(vectors.at<double>(2, 0), vectors.at<double>(2, 1), vectors.at<double>(2, 2));
    if (next.dot(upright) < 0) next = -next;
    best = next;
  }
  return best->dot(upright) < cosOfTilt ? std::nullopt : best;
}

std::string Leveling::toBytes(std::size_t frame) const {
  ByteWriter bytes;
  if (const auto seen = views_.find(frame); seen != views_.end())
    for (const Face& face : seen->second)
      for (const double value : {face.normal[0], face.normal[1], face.normal[2], face.weight})
        bytes.number(value);
  return bytes.bytes();
}

void Leveling::fromBytes(std::size_t frame, const std::string& row) {
  ByteReader bytes(row, "the planes of a view", "make the map anew");
  std::vector<Face>& faces = views_[frame];
  faces.clear();
  while (bytes.remaining() > 0) {
    Face face;
    for (int i = 0; i < 3; ++i) face.normal[i] = bytes.number<double>();
    face.weight = bytes.number<double>();
    if (!(std::abs(cv::norm(face.normal) - 1) < 1e-3) || !(face.weight >= 0 && face.weight <= maxArea))
      bytes.fail("a plane has no direction or no size");
    faces.push_back(face);
  }
}

cv::Affine3d levelRotation(const cv::Vec3d& up) {
  const cv::Vec3d z = cv::normalize(up), ahead(1, 0, 0);
  const cv::Vec3d x = cv::normalize(ahead - z * z.dot(ahead)), y = z.cross(x);
  return cv::Affine3d(cv::Matx33d(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]), cv::Vec3d());
}

}  // namespace estancia
