// Reference room segmentation on two made-up rooms and a door.
// SPDX-License-Identifier: Apache-2.0
#include "places/reference_areas.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace estancia::experiments {
namespace {

constexpr double kCell = 0.1;

/// Rooms of 6 × 6 m at both sides of a wall, with a door of so many cells; the distance to walls [m].
cv::Mat twoRooms(int door) {
  cv::Mat freeSpace(62, 123, CV_8U, cv::Scalar(0)), distance;
  freeSpace(cv::Rect(1, 1, 60, 60)) = 255;
  freeSpace(cv::Rect(62, 1, 60, 60)) = 255;
  freeSpace(cv::Rect(61, 31 - door / 2, 1, door)) = 255;
  cv::distanceTransform(freeSpace, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * kCell;
}

void expectSplitAtDoors(RoomMethod method) {
  const cv::Mat split = method(twoRooms(9), kCell);
  double most = 0;
  cv::minMaxLoc(split, nullptr, &most);
  EXPECT_EQ(most, 2);
  EXPECT_NE(split.at<int>(5, 5), split.at<int>(5, 117));
  EXPECT_EQ(split.at<int>(5, 5), split.at<int>(55, 58)) << "a room is one to its corners";
  EXPECT_EQ(split.at<int>(0, 0), 0);
  const cv::Mat one = method(twoRooms(60), kCell);
  cv::minMaxLoc(one, nullptr, &most);
  EXPECT_EQ(most, 1) << "no wall, no rooms";
  const cv::Mat none = method(cv::Mat(5, 5, CV_32F, cv::Scalar(0)), kCell);
  EXPECT_EQ(cv::countNonZero(none), 0);
}

TEST(ReferenceAreas, ByErosionSplitAtDoors) {
  expectSplitAtDoors(morphologicalRooms);
}

TEST(ReferenceAreas, ByDistanceSplitAtDoors) {
  expectSplitAtDoors(distanceTransformRooms);
}

}  // namespace
}  // namespace estancia::experiments
