// Which way is up, by the planes that a drive sees.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/leveling.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estancia/core/pose.hpp"

namespace estancia {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// A camera that looks down by `pitch` and leans to the right by `roll` [rad], before it is turned by `yaw`.
cv::Affine3d tilted(double yaw, double pitch, double roll) {
  const cv::Affine3d nod(cv::Vec3d(-pitch, 0, 0), cv::Vec3d()), lean(cv::Vec3d(0, 0, roll), cv::Vec3d());
  return rigidOf(Pose::planar(0, 0, yaw)) * nod * lean;
}

/// Planes of a world with z up, as a camera sees them.
std::vector<Plane> seenBy(const cv::Affine3d& camera, const std::vector<cv::Vec3d>& normals) {
  std::vector<Plane> planes;
  for (const cv::Vec3d& normal : normals)
    planes.push_back({.normal = camera.rotation().t() * cv::normalize(normal), .offset = -1, .area = 1});
  return planes;
}

const cv::Vec3d floorUp(0, 0, 1), wallA(-1, 0, 0), wallB(0, 1, 0), back(-1, 0, 0.4);

/// What is off of the up that a map finds whose first camera was tilted so [degrees]; nothing without one.
std::optional<double> errorOfUp(const std::vector<std::vector<cv::Vec3d>>& views, double pitch, double roll) {
  Leveling leveling;
  std::vector<std::optional<Pose>> poses;
  const cv::Affine3d first = tilted(0, pitch, roll);
  const cv::Affine3d map = rigidOf(Pose::planar(0, 0, 0)) * first.inv();  // takes the first one for level
  for (std::size_t i = 0; i < views.size(); ++i) {
    const cv::Affine3d camera = tilted(0.3 * static_cast<double>(i), pitch, roll);
    leveling.add(i, seenBy(camera, views[i]));
    poses.push_back(poseOf(map * camera));
  }
  const auto up = leveling.up(poses);
  if (!up) return std::nullopt;
  return std::acos(std::min(1.0, up->dot(map.rotation() * cv::Vec3d(0, 0, 1)))) / degree;
}

TEST(Leveling, FindsUpByFloorAndTablesOrByWalls) {
  for (const double pitch : {-40, 0, 9})
    for (const double roll : {-15, 0}) {
      SCOPED_TRACE(testing::Message() << pitch << " " << roll);
      const double p = pitch * degree, r = roll * degree;
      EXPECT_LT(errorOfUp({{floorUp}}, p, r).value_or(90), 0.01) << "the floor";
      EXPECT_LT(errorOfUp({{floorUp, wallA, back}, {wallA, wallB, back}}, p, r).value_or(90), 0.01)
          << "a leaning back is no level plane";
      EXPECT_LT(errorOfUp({{wallA}, {wallA, wallB}}, p, r).value_or(90), 0.01) << "walls";
    }
}

TEST(Leveling, SaysNothingOfWhatItHasNotSeen) {
  EXPECT_FALSE(errorOfUp({{}, {}}, 0.1, 0));
  EXPECT_FALSE(errorOfUp({{wallA}, {wallA}}, 0.1, 0)) << "one wall is upright, whichever way is up";
  EXPECT_FALSE(errorOfUp({{floorUp}}, 60 * degree, 0)) << "then it may be a wall";
}

TEST(Leveling, TurnsTheMapThatZIsUpAndTheFirstCameraLooksAlongX) {
  const cv::Affine3d first = tilted(0, 0.4, -0.2);
  const cv::Vec3d up = rigidOf(Pose::planar(0, 0, 0)) * (first.inv() * cv::Vec3d(0, 0, 1));
  const cv::Affine3d level = levelRotation(up) * rigidOf(Pose::planar(0, 0, 0));
  EXPECT_LT(cv::norm(level.rotation() - first.rotation()), 1e-12);
  EXPECT_LT(cv::norm(levelRotation({0, 0, 2}).rotation() - cv::Matx33d::eye()), 1e-15);
}

}  // namespace
}  // namespace estancia
