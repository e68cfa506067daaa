// Room segmentation of drawn floor plans.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/room_segmentation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

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

}  // namespace
}  // namespace estancia
