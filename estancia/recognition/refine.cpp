// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/refine.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estancia/recognition/keypoints.hpp"

namespace estancia {
namespace {

constexpr double minDot = 0.5;  // cosine of normals that can be of the same surface
constexpr std::size_t minPartners = 10;

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The normal equations of one round: rotation around `center`, the model's center in the scene, then
/// translation.
struct Equations {
  Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 right = Vector6::Zero();
  std::size_t partners = 0;
};

Equations equationsOf(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                      const cv::Vec3d& center, double reach) {
  Equations sum;
  std::vector<Neighbor> buffer;
  const double reach2 = reach * reach;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3d p = pose * cv::Point3d(model.points[i]);
    const auto near = scene.neighbors().nearest(cv::Point3f(p), 1, buffer, static_cast<float>(reach));
    if (near.empty()) continue;
    const cv::Vec3d n(cv::Point3d(scene.normals()[near[0].index]));
    const cv::Vec3d m = pose.rotation() * cv::Vec3d(cv::Point3d(model.normals[i]));
    if (n.dot(m) < minDot) continue;
    const double shrink = 1 - static_cast<double>(near[0].squared) / reach2;
    const double weight = shrink * shrink;
    const cv::Vec3d q(cv::Point3d(scene.points()[near[0].index])), at(p);
    const cv::Vec3d turn = (at - center).cross(n);
    Vector6 row;
    row << turn[0], turn[1], turn[2], n[0], n[1], n[2];
    sum.left += weight * row * row.transpose();
    sum.right += weight * n.dot(q - at) * row;
    ++sum.partners;
  }
  return sum;
}

OrientedPoints chosenFrom(const Surface& surface, const std::vector<std::uint32_t>& indices) {
  OrientedPoints chosen;
  for (const std::uint32_t i : indices) {
    chosen.points.push_back(surface.points()[i]);
    chosen.normals.push_back(surface.normals()[i]);
    if (!surface.lab().empty()) chosen.lab.push_back(surface.lab()[i]);
  }
  return chosen;
}

}  // namespace

OrientedPoints spreadPoints(const Surface& surface, std::size_t count) {
  if (surface.size() <= count || !(surface.extent() > 0))
    return {surface.points(), surface.normals(), {}, surface.lab()};
  // Bisection: half the edge of a voxel, four times as many points.
  double low = surface.extent() / 1e5, high = surface.extent();
  std::vector<std::uint32_t> best;
  for (int step = 0; step < 12; ++step) {
    const double middle = std::sqrt(low * high);
    std::vector<std::uint32_t> chosen = findKeypoints(surface, "uniform", middle);
    const bool tooMany = chosen.size() > count;
    if (best.empty() || (!tooMany && chosen.size() > best.size()) || best.size() > count)
      best = std::move(chosen);
    (tooMany ? low : high) = middle;
  }
  return chosenFrom(surface, best);
}

OrientedPoints spreadPointsBy(const Surface& surface, double spacing) {
  return chosenFrom(surface, findKeypoints(surface, "uniform", spacing));
}

cv::Affine3d refinePose(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                        double reach, int rounds) {
  cv::Point3d middle;
  for (const cv::Point3f& p : model.points)
    middle += cv::Point3d(p) / static_cast<double>(model.points.size());
  double size = 0;
  for (const cv::Point3f& p : model.points) size = std::max(size, cv::norm(cv::Point3d(p) - middle));
  cv::Affine3d refined = pose;
  for (int round = 0; round < rounds; ++round) {
    const cv::Vec3d center(refined * middle);
    Equations e = equationsOf(model, scene, refined, center, reach);
    if (e.partners < minPartners) return round == 0 ? pose : refined;
    // Damping: planes and spheres do not fix all directions; in those the pose stays.
    for (int k = 0; k < 6; ++k)
      e.left(k, k) += 1e-6 * static_cast<double>(e.partners) * (k < 3 ? size * size : 1);
    const Vector6 x = e.left.ldlt().solve(e.right);
    if (!x.allFinite()) return refined;
    const cv::Affine3d turn(cv::Vec3d(x[0], x[1], x[2]));
    const cv::Vec3d shift(x[3], x[4], x[5]);
    // p → R (p − center) + center + shift
    refined = cv::Affine3d(turn.rotation(), center - turn.rotation() * center + shift) * refined;
    if (x.head<3>().norm() * size + x.tail<3>().norm() < 1e-3 * reach) break;
  }
  return refined;
}

}  // namespace estancia
