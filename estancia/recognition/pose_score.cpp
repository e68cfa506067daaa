// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/pose_score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estancia/recognition/color_term.hpp"

namespace estancia {
namespace {

constexpr float grazing = 0.15F;  // cosine below which a sensor measures nothing of a surface

/// cv's operators have loops that are not unrolled.
inline cv::Point3f moved(const cv::Matx33f& m, const cv::Point3f& p) {
  return {m.val[0] * p.x + m.val[1] * p.y + m.val[2] * p.z, m.val[3] * p.x + m.val[4] * p.y + m.val[5] * p.z,
          m.val[6] * p.x + m.val[7] * p.y + m.val[8] * p.z};
}

/// Whether it could be visible to a sensor at the origin.
inline bool faces(const cv::Point3f& p, const cv::Point3f& n) {
  const float along = n.dot(p);
  return along <= 0 && along * along >= grazing * grazing * p.dot(p);
}

/// scorePose(), and onSupport(index of the scene's point, weight) for each supported point.
template <class OnSupport>
PoseScore score(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                const PoseTolerances& limits, const OnSupport& onSupport) {
  const cv::Matx33f turn(pose.rotation());
  const cv::Point3f shift(cv::Vec3f(pose.translation()));
  const auto offset = static_cast<float>(limits.offset), freeSpace = static_cast<float>(limits.freeSpace),
             minDot = static_cast<float>(limits.minDot);
  const float perOffset = 1 / (offset * offset), perAngle = 1 / (1 - minDot);
  const bool seen = scene.view.known();
  const bool colored = limits.color > 0 && !model.lab.empty() && !scene.surface.lab().empty();
  float total = 0, facing = 0, supported = 0, seenThrough = 0, occluded = 0, mismatched = 0, behind = 0,
        support = 0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = moved(turn, model.points[i]) + shift, n = moved(turn, model.normals[i]);
    const float w = model.weights.empty() ? 1 : model.weights[i];
    total += w;
    if (seen && !faces(p, n)) {
      const auto depths = scene.view.depthsAround(p);
      if (depths && depths->nearest > p.z + freeSpace) behind += w;
      continue;
    }
    facing += w;
    const std::int32_t near = scene.field.at(p);
    if (near != NearestField::none) {
      const auto k = static_cast<std::size_t>(near);
      const cv::Point3f& m = scene.surface.normals()[k];
      const float off = std::abs(m.dot(p - scene.surface.points()[k])), dot = cosineOf(m, n, seen);
      if (off < offset && dot > minDot &&
          !(colored && colorDifference(model.lab[i], scene.surface.lab()[k]) > limits.color)) {
        ++points;
        supported += w;
        const float weight = w * (1 - off * off * perOffset) * (1 - (1 - dot) * perAngle);
        support += weight;
        onSupport(k, weight);
        continue;
      }
      if (!seen) mismatched += w;
    }
    if (!seen) continue;
    const auto depths = scene.view.depthsAround(p);
    if (!depths) continue;
    if (depths->nearest > p.z + freeSpace)
      seenThrough += w;
    else if (depths->farthest < p.z - freeSpace)
      occluded += w;
    else
      mismatched += w;
  }
  if (!(total > 0)) return {};
  return {.facing = facing / total,
          .supported = supported / total,
          .seenThrough = seenThrough / total,
          .occluded = occluded / total,
          .mismatched = mismatched / total,
          .behind = behind / total,
          .support = support / total,
          .points = points};
}

}  // namespace

PoseScore scorePose(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                    const PoseTolerances& limits) {
  return score(model, scene, pose, limits, [](std::size_t, float) {});
}

std::vector<PointSupport> supportOf(const OrientedPoints& model, const DenseScene& scene,
                                    const cv::Affine3d& pose, const PoseTolerances& limits) {
  std::vector<PointSupport> points;
  score(model, scene, pose, limits, [&](std::size_t point, float weight) {
    points.push_back({static_cast<std::uint32_t>(point), weight});
  });
  return points;
}

void balanceNormals(OrientedPoints& model) {
  constexpr float similar = 0.94F;  // cosine of 20°
  constexpr double power = -0.5;
  model.weights.assign(model.points.size(), 1);
  double sum = 0;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const auto same = std::count_if(model.normals.begin(), model.normals.end(),
                                    [&](const cv::Point3f& n) { return n.dot(model.normals[i]) > similar; });
    model.weights[i] = static_cast<float>(std::pow(std::max<double>(1, static_cast<double>(same)), power));
    sum += static_cast<double>(model.weights[i]);
  }
  for (float& w : model.weights) w = static_cast<float>(w * static_cast<double>(model.points.size()) / sum);
}

cv::Affine3d refineInField(const OrientedPoints& model, const cv::Point3d& center, const DenseScene& scene,
                           const cv::Affine3d& pose, const FieldRefinement& options) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  constexpr float minDot = 0.5F;  // cosine of normals that can be of the same surface
  constexpr int minPartners = 12;
  constexpr double damping =
      1e-5;  // share of the strongest direction: planes and spheres do not fix all directions
  constexpr double maxRotation = 0.3;     // [rad] a round
  constexpr double stillRotation = 2e-4;  // [rad]
  const bool seen = scene.view.known();
  cv::Affine3d refined = pose;
  ColorTerm color(model.lab, scene.surface, scene.gradients, options.color);
  double size = 0;
  for (const cv::Point3f& p : model.points) size = std::max(size, cv::norm(cv::Point3d(p) - center));
  for (int round = 0; round < options.rounds; ++round) {
    const auto reach = static_cast<float>(options.firstReach + (options.lastReach - options.firstReach) *
                                                                   round / std::max(1, options.rounds - 1));
    const cv::Affine3f transform(refined);
    const cv::Matx33f turn = transform.rotation();
    const cv::Point3f middle = transform * cv::Point3f(center);
    Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6 right = Vector6::Zero();
    int partners = 0;
    for (std::size_t i = 0; i < model.points.size(); ++i) {
      const cv::Point3f p = transform * model.points[i], n = turn * model.normals[i];
      if (seen && !faces(p, n)) continue;
      const std::int32_t near = scene.field.at(p);
      if (near == NearestField::none) continue;
      const auto k = static_cast<std::size_t>(near);
      const cv::Point3f& m = scene.surface.normals()[k];
      if (cosineOf(m, n, seen) < minDot) continue;
      const float off = m.dot(scene.surface.points()[k] - p);
      if (std::abs(off) > reach) continue;
      const double weight = 1 - static_cast<double>(off * off / (reach * reach));
      const cv::Point3f lever = (p - middle).cross(m);
      Vector6 row;
      row << lever.x / size, lever.y / size, lever.z / size, m.x, m.y, m.z;
      left.noalias() += weight * row * row.transpose();
      right.noalias() += weight * static_cast<double>(off) * row;
      color.add(i, k, p, middle, size, weight, static_cast<double>(reach), left, right);
      ++partners;
    }
    color.endRound();
    if (partners < minPartners) return refined;
    left.diagonal().array() += damping * left.diagonal().maxCoeff();
    const Vector6 x = left.ldlt().solve(right);
    if (!x.allFinite()) return refined;
    cv::Vec3d rotation(x[0] / size, x[1] / size, x[2] / size);
    const cv::Vec3d shift(x[3], x[4], x[5]);
    const double angle = cv::norm(rotation);
    if (angle > maxRotation) rotation *= maxRotation / angle;
    const cv::Affine3d by(rotation);
    const cv::Vec3d at(refined * center);
    // p → R (p − center) + center + shift
    refined = cv::Affine3d(by.rotation(), at - by.rotation() * at + shift) * refined;
    if (round == 0 && color.on()) continue;  // color is not used before the second round
    if (angle < stillRotation && cv::norm(shift) < stillRotation * size / 5) break;
  }
  return refined;
}

}  // namespace estancia
