// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/keypoints.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

std::vector<std::uint32_t> uniform(const Surface& surface, double spacing) {
  // share of the resolution; below, voxels exceed the precision of a float
  constexpr double minSpacing = 1e-6;
  if (!(spacing > minSpacing * surface.resolution()))
    fail(ErrorCode::invalidOption,
         "{}: the keypoint spacing is {} m on a cloud of {:.4g} m; give about {:.4g} m", surface.name(),
         spacing, surface.extent(), 5 * surface.resolution());
  return onePerVoxel(surface.points(), spacing);
}

/// Non-maximum suppression: the points whose response is positive and the largest within `radius`; the first
/// of equal ones.
std::vector<std::uint32_t> strongest(const Surface& surface, const std::vector<float>& response,
                                     double radius, int threads) {
  std::vector<char> isKeypoint(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(radius), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        isKeypoint[i] =
            response[i] > 0 && std::all_of(near.begin(), near.end(), [&](const Neighbor& n) {
              return response[n.index] < response[i] || (response[n.index] == response[i] && n.index >= i);
            });
      });
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < surface.size(); ++i)
    if (isKeypoint[i]) chosen.push_back(i);
  return chosen;
}

/// Σ v vᵀ
struct Scatter {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  void add(const cv::Point3f& v) {
    xx += v.x * v.x, xy += v.x * v.y, xz += v.x * v.z, yy += v.y * v.y, yz += v.y * v.z, zz += v.z * v.z;
  }
};

std::vector<std::uint32_t> harris3d(const Surface& surface, double spacing, int threads) {
  std::vector<float> response(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(spacing), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        Scatter sum;
        for (const Neighbor& n : near) sum.add(surface.normals()[n.index]);
        const auto [xx, xy, xz, yy, yz, zz] = sum;
        const double per = 1.0 / static_cast<double>(near.size());
        const double trace = (xx + yy + zz) * per;
        const double det =
            per * per * per *
            (static_cast<double>(xx) * yy * zz + 2.0 * xy * xz * yz - static_cast<double>(xz) * xz * yy -
             static_cast<double>(xy) * xy * zz - static_cast<double>(yz) * yz * xx);
        response[i] = static_cast<float>(0.04 + det - 0.04 * trace * trace);
      });
  // Unit normals have a trace of 1: on a plane, rounding of 0.04 − 0.04 must not make corners.
  for (float& r : response)
    if (r < 1e-6F) r = 0;
  return strongest(surface, response, spacing, threads);
}

std::vector<std::uint32_t> iss(const Surface& surface, double spacing, int threads) {
  constexpr double ratio = 0.975;
  constexpr std::size_t minNeighbors = 5;
  std::vector<float> salience(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(spacing), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        if (near.size() < minNeighbors) return;
        const cv::Point3f& p = surface.points()[i];
        Scatter sum;
        for (const Neighbor& n : near) sum.add(surface.points()[n.index] - p);
        const auto [xx, xy, xz, yy, yz, zz] = sum;
        Eigen::Matrix3d scatter;
        scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
        const Eigen::Vector3d e =
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
        // Eigenvalues from rounding are ignored: a plane has no salient point.
        if (e[0] > 1e-6 * e[2] && e[1] < ratio * e[2] && e[0] < ratio * e[1])
          salience[i] = static_cast<float>(e[0]);
      });
  return strongest(surface, salience, spacing * 2 / 3, threads);
}

}  // namespace

Choices keypointMethods() {
  return {{"uniform", "one point a voxel"},
          {"harris3d", "where normals vary in all directions"},
          {"iss", "intrinsic shape signatures: three different variances of the points around"}};
}

std::vector<std::uint32_t> findKeypoints(const Surface& surface, const std::string& method, double spacing,
                                         int threads) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    fail(ErrorCode::invalidOption, "{}: the keypoint spacing is {} m; give a positive one", surface.name(),
         spacing);
  requireChoice("keypoint detector", method, keypointMethods());
  if (method == "uniform") return uniform(surface, spacing);
  return method == "harris3d" ? harris3d(surface, spacing, threads) : iss(surface, spacing, threads);
}

}  // namespace estancia
