// Grids of a map: what is free, where rooms part, and which words were seen.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/occupancy_grid.hpp"

#include <gmock/gmock.h>

#include <array>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estancia/areas/room_segmentation.hpp"
#include "estancia/areas/word_map.hpp"
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
  const cv::Mat depth = boxDepth(here, {-2, -1.5, 4, 3});
  grid.add(depth, smallCamera(), here);
  const double before = freeArea(grid);
  EXPECT_THAT([&] { grid.add(depth, smallCamera(), far); }, FailsWith(ErrorCode::tooLarge));
  EXPECT_EQ(freeArea(grid), before);
}

constexpr double cell = 0.05;

/// A plan of free rectangles [m] in walls.
class Plan {
 public:
  Plan(double width, double height)
      : space_(cv::Size(static_cast<int>(width / cell), static_cast<int>(height / cell)), CV_8U,
               cv::Scalar(0)) {}

  Plan& add(double x, double y, double width, double height) {
    space_(cv::Rect2i(cells(x), cells(y), cells(width), cells(height))).setTo(255);
    return *this;
  }
  Plan& block(double x, double y, double width, double height) {
    space_(cv::Rect2i(cells(x), cells(y), cells(width), cells(height))).setTo(0);
    return *this;
  }

  cv::Mat rooms(const RoomSegmentationOptions& options = {}) const {
    return segmentRooms(space_, space_ == 0, cell, options);
  }

 private:
  static int cells(double meters) { return static_cast<int>(std::lround(meters / cell)); }
  cv::Mat space_;
};

int roomAt(const cv::Mat& rooms, double x, double y) {
  return rooms.at<int>(static_cast<int>(y / cell), static_cast<int>(x / cell));
}

int count(const cv::Mat& rooms) {
  double most = 0;
  cv::minMaxLoc(rooms, nullptr, &most);
  return static_cast<int>(most);
}

/// Two rooms and a corridor of 1.3 m below, each with a door of this width.
Plan flat(double door) {
  return Plan(10, 8)
      .add(0.5, 0.5, 4, 4)
      .add(5, 0.5, 4, 4)
      .add(0.5, 4.7, 8.5, 1.3)
      .add(2, 4.4, door, 0.5)
      .add(6, 4.4, door, 0.5);
}

TEST(RoomSegmentation, PartsRoomsAtTheirDoors) {
  for (const double door : {0.7, 1.2}) {
    const cv::Mat rooms = flat(door).rooms();
    EXPECT_EQ(count(rooms), 3) << door;
    EXPECT_EQ(roomAt(rooms, 1, 1), roomAt(rooms, 4, 4));
    EXPECT_NE(roomAt(rooms, 1, 1), roomAt(rooms, 6, 1));
    EXPECT_EQ(roomAt(rooms, 0.7, 5), roomAt(rooms, 8.5, 5.8)) << "the corridor is one";
    EXPECT_NE(roomAt(rooms, 1, 1), roomAt(rooms, 1, 5));
  }
}

TEST(RoomSegmentation, KeepsARoomWithACupboardAndAnOpenPlanWhole) {
  Plan plan(8, 6);
  plan.add(0.5, 0.5, 7, 3).block(3.5, 0.5, 0.6, 0.8);  // narrows the room from 3 to 2.2 m
  EXPECT_EQ(count(plan.rooms()), 1);
  EXPECT_EQ(count(Plan(12, 8).add(0.5, 0.5, 6, 5).add(6.5, 0.5, 4, 5).rooms()), 1) << "a wide opening";
  EXPECT_EQ(count(Plan(2, 2).rooms()), 0);
  EXPECT_TRUE(segmentRooms(cv::Mat(), cv::Mat(), cell).empty());
}

TEST(RoomSegmentation, NumbersRoomsByFallingSizeAndLeavesWallsOut) {
  const Plan plan = Plan(10, 6).add(0.5, 0.5, 2, 2).add(3, 0.5, 5, 5).add(2.4, 1, 0.7, 0.8);
  const cv::Mat rooms = plan.rooms();
  EXPECT_EQ(roomAt(rooms, 5, 3), 1);
  EXPECT_EQ(roomAt(rooms, 1, 2), 2);
  EXPECT_EQ(roomAt(rooms, 9, 5), 0);
}

TEST(RoomSegmentation, DropsSpecksAndOptionsDecide) {
  Plan plan = flat(0.9);
  plan.add(9.5, 7.5, 0.3, 0.3);  // seen through a hole in the wall
  EXPECT_EQ(roomAt(plan.rooms(), 9.6, 7.6), 0);
  EXPECT_EQ(count(plan.rooms({.mutualVisibility = 0.01})), 1);
  EXPECT_THAT([&] { plan.rooms({.mutualVisibility = 2}); }, FailsWith(ErrorCode::invalidOption));
}

const cv::Rect2d room(0, 0, 5, 4);
constexpr std::array<std::size_t, 1> mug{1};

/// Whether the camera looks at the corner (5, 4), within its field of view.
bool seesCorner(double x, double y, double heading) {
  return std::abs(wrapped(std::atan2(4 - y, 5 - x) - heading)) < 0.5;
}

WordMap mapOfRoom(bool withDepth, std::size_t labels = 4) {
  std::vector<Pose> poses;
  std::vector<bool> seen;
  for (const auto& [x, y] :
       {std::pair(1.0, 1.0), std::pair(4.0, 1.0), std::pair(1.5, 3.0), std::pair(3.5, 2.5)})
    for (int i = 0; i < 12; ++i) {
      const double heading = i * std::numbers::pi / 6;
      poses.push_back(lookingAt(x, y, 1, heading, -0.1));
      seen.push_back(seesCorner(x, y, heading));
    }
  WordMap map(Floor(poses), labels);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    LexicalDescriptor words(labels, 0.0F);
    words[0] = seen[i] ? 0.2F : 0.9F;
    words[1] = seen[i] ? 0.7F : 0.01F;
    if (withDepth)
      map.add(words, boxDepth(poses[i], room), smallCamera(), poses[i]);
    else
      map.add(words, 1.1, poses[i]);
  }
  return map;
}

cv::Point2d strongest(const FloorHeat& heat) {
  cv::Point best;
  cv::minMaxLoc(heat.values, nullptr, nullptr, nullptr, &best);
  return heat.cells.centerOf(best);
}

TEST(WordMap, KeepsTheMostProbableOfManyLabels) {
  const Pose pose = lookingAt(2, 2, 1, 0, -0.1);
  WordMap map(Floor(std::vector{pose}), 400);
  LexicalDescriptor words(400);
  for (std::size_t l = 0; l < words.size(); ++l) words[l] = static_cast<float>(l / 8 + 1) / 50;
  for (int i = 0; i < 3; ++i) map.add(words, 1.1, pose);
  const auto heatOf = [&](std::size_t label) {
    double most = 0;
    cv::minMaxLoc(map.heat(std::array<std::size_t, 1>{label}).values, nullptr, &most);
    return most;
  };
  EXPECT_GT(heatOf(399), 0);
  EXPECT_GT(heatOf(399), heatOf(0));
}

TEST(WordMap, FindsAThingWhereTheViewsCross) {
  const cv::Point2d at = strongest(mapOfRoom(true).heat(mug));
  EXPECT_LT(std::hypot(at.x - 5, at.y - 4), 0.75);
}

TEST(WordMap, WithoutDepthKnowsTheSide) {
  const WordMap map = mapOfRoom(false);
  const FloorHeat heat = map.heat(mug);
  const auto valueAt = [&](double x, double y) { return heat.values.at<float>(heat.cells.at(x, y)); };
  EXPECT_GT(valueAt(4.5, 3.5), 3 * valueAt(0.5, 0.5));
}

TEST(WordMap, MeansOfCellsArePooledByWhatWasSeen) {
  const WordMap map = mapOfRoom(true);
  const cv::Mat all(map.cells().rows(), map.cells().columns(), CV_8U, cv::Scalar(255));
  const std::vector<float> mean = map.mean(all);
  EXPECT_GT(mean[0], mean[1]);
  EXPECT_GT(mean[1], 0.02F);
  EXPECT_EQ(mean[2], 0);  // never more probable than by chance
  EXPECT_THAT(map.mean(all * 0), testing::Each(0.0F));
}

TEST(WordMap, RefusesWhatDoesNotFit) {
  const Pose pose = lookingAt(1, 1, 1, 0, 0);
  WordMap map(Floor(std::vector{pose}), 4);
  EXPECT_THAT([&] { map.add(LexicalDescriptor(3, 0.1F), 1.0, pose); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { map.heat(std::array<std::size_t, 1>{4}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_TRUE(map.heat(mug).values.empty());
}

}  // namespace
}  // namespace estancia
