// Areas that are found anew keep their numbers.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/plan_areas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace estancia {
namespace {

/// Areas of these cells of a floor of 100 × 100, in this order, seen by a frame in each.
PlannedFrames planOf(const std::vector<cv::Rect>& areas, cv::Point origin = {}) {
  PlannedFrames planned{
      AreaPlan{{}, Floor(cv::Vec3d(0, 0, 1)), FloorCells(0.1, cv::Rect(origin, cv::Size(100, 100))), {}, {}},
      {},
      {}};
  planned.plan.areaOf = cv::Mat(100, 100, CV_32S, cv::Scalar(-1));
  for (const cv::Rect& cells : areas) {
    const int id = static_cast<int>(planned.plan.areas.size());
    planned.plan.areaOf(cells - origin) = id;
    planned.plan.areas.push_back({id, "area of width " + std::to_string(cells.width)});
    planned.areaOfFrame.push_back(id);
  }
  planned.areaOfFrame.push_back(-1);
  return planned;
}

const cv::Rect kitchen(0, 0, 20, 20), hall(20, 0, 40, 10), bedroom(60, 0, 30, 30);

TEST(AreaNumbers, AreThoseOfWhereTheyLie) {
  const AreaPlan before = planOf({kitchen, hall, bedroom}).plan;
  PlannedFrames now = planOf({bedroom, kitchen, hall});
  keepNumbers(now, before);
  EXPECT_THAT(now.areaOfFrame, testing::ElementsAre(2, 0, 1, -1));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(now.plan.areas[i].id, static_cast<int>(i));
    EXPECT_EQ(now.plan.areas[i].name, before.areas[i].name);
  }
  EXPECT_EQ(now.plan.areaOf.at<int>(5, 5), 0);
  EXPECT_EQ(now.plan.areaOf.at<int>(5, 70), 2);
  EXPECT_EQ(now.plan.areaOf.at<int>(99, 99), -1);
}

TEST(AreaNumbers, StayWhereTheMapGrowsAndInTheLargerPartOfASplitArea) {
  PlannedFrames grown = planOf({{-10, 0, 9, 9}, hall, kitchen}, {-10, -5});
  keepNumbers(grown, planOf({kitchen, hall}).plan);
  EXPECT_THAT(grown.areaOfFrame, testing::ElementsAre(2, 1, 0, -1));
  const AreaPlan before = planOf({hall, bedroom}).plan;
  PlannedFrames now = planOf({{20, 0, 10, 10}, bedroom, {30, 0, 30, 10}});
  keepNumbers(now, before);
  EXPECT_THAT(now.areaOfFrame, testing::ElementsAre(2, 1, 0, -1));
}

}  // namespace
}  // namespace estancia
