// Occupancy grids of made-up rooms, seen by cameras whose depth is computed.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/occupancy_grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/errors.hpp"
#include "support/floor_scene.hpp"

namespace estancia {
namespace {

using test::boxDepth;
using test::FailsWith;
using test::lookingAt;
using test::smallCamera;

constexpr double quarter = std::numbers::pi / 2;

/// A camera that turns once around in the middle of a box of 4 × 3 m.
OccupancyGrid turnedInBox(double tilt, double noise = 0) {
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(lookingAt(0, 0, 1, i * quarter / 3, tilt));
  OccupancyGrid grid(Floor(poses), 0.05);
  cv::RNG random(7);
  for (const Pose& pose : poses) {
    cv::Mat depth = boxDepth(pose, {-2, -1.5, 4, 3});
    if (noise > 0) {
      cv::Mat error(depth.size(), CV_32F);
      random.fill(error, cv::RNG::NORMAL, 0, 1);
      depth += noise * depth.mul(depth).mul(error);
    }
    grid.add(depth, smallCamera(), pose);
  }
  return grid;
}

double freeArea(const OccupancyGrid& grid) {
  return cv::countNonZero(grid.freeSpace()) * grid.cells().cell() * grid.cells().cell();
}

TEST(OccupancyGrid, FreesTheFloorOfARoomAndNoMore) {
  const OccupancyGrid grid = turnedInBox(0);
  EXPECT_NEAR(freeArea(grid), 12, 0.8);
  const cv::Point wall = grid.cells().at(1.99, 0.3), inside = grid.cells().at(1.5, 0.3);
  const cv::Mat walls = grid.walls(), space = grid.freeSpace();
  EXPECT_GT(cv::countNonZero(walls(cv::Rect(wall.x - 1, wall.y, 3, 1))), 0);
  EXPECT_EQ(walls.at<unsigned char>(inside), 0);
  EXPECT_EQ(space.at<unsigned char>(inside), 255);
}

/// The plan of a live map is made of a copy by another thread, while views are added.
TEST(OccupancyGrid, LeavesItsCopiesAsTheyWere) {
  OccupancyGrid grid = turnedInBox(0);
  const OccupancyGrid copy = grid;
  const cv::Mat walls = copy.walls(), space = copy.freeSpace();
  const Pose pose = lookingAt(0, 0, 1, 0, 0);
  for (int i = 0; i < 5; ++i) grid.add(boxDepth(pose, {-1, -1, 2, 2}), smallCamera(), pose);
  ASSERT_GT(cv::norm(grid.walls(), walls, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(copy.walls(), walls, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(copy.freeSpace(), space, cv::NORM_INF), 0);
}

TEST(OccupancyGrid, NeedsNoLevelCameraAndBearsNoise) {
  EXPECT_NEAR(freeArea(turnedInBox(-0.35)), 12, 0.8);        // 20° down
  EXPECT_NEAR(freeArea(turnedInBox(0.2)), 12, 0.8);          // up
  EXPECT_NEAR(freeArea(turnedInBox(-0.1, 0.003)), 12, 1.0);  // 2.5 times a Kinect's noise
}

TEST(OccupancyGrid, RefusesPosesThatSpanTooMuch) {
  const Pose here = lookingAt(0, 0, 1, 0, 0), far = lookingAt(5e6, 0, 1, 0, 0);
  OccupancyGrid grid(Floor(std::vector{here, far}), 0.05);
  grid.add(boxDepth(here, {-2, -1.5, 4, 3}), smallCamera(), here);
  const double before = freeArea(grid);
  EXPECT_THAT(
      [&] {
        grid.add(boxDepth(here, {-2, -1.5, 4, 3}), smallCamera(), far);
      },
      FailsWith(ErrorCode::tooLarge));
  EXPECT_EQ(freeArea(grid), before);
}

}  // namespace
}  // namespace estancia
