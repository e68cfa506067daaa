// Corrections of a floor plan by people.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/plan_areas.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/vocabulary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace estancia {
namespace {

using testing::ElementsAre;

/// A room of two arms, 1 m wide, that meet at the bottom: x from 0 to 1 and from 4 to 5 m, y up to 6 m.
/// Beside it, behind a wall, a closet.
AreaPlan twoArms() {
  AreaPlan plan{{}, Floor(cv::Vec3d(0, 0, 1)), FloorCells(0.1, {0, 0, 80, 60}), {}, {}};
  plan.areaOf = cv::Mat(60, 80, CV_32S, cv::Scalar(-1));
  plan.walls = cv::Mat(60, 80, CV_8U, cv::Scalar(0));
  for (const cv::Rect& part : {cv::Rect(0, 0, 10, 60), cv::Rect(40, 0, 10, 60), cv::Rect(0, 0, 50, 10)})
    plan.areaOf(part) = 0;
  plan.areaOf(cv::Rect(60, 0, 20, 20)) = 1;
  plan.areas.resize(2);
  return plan;
}

std::optional<AreaPlan> corrected(const AreaPlan& plan, AreaEdit::Kind kind, const cv::Point2d& from,
                                  const cv::Point2d& to) {
  FramePoses frames;
  frames.add(Pose::planar(0.5, 0.5, 0));
  auto planned = correctPlan(plan, {kind, from, to}, {frames}, WordMap(plan.floor, 1),
                             Vocabulary(std::vector<std::string>{"wall"}), {0.1F});
  if (!planned) return std::nullopt;
  return planned->plan;
}

std::vector<int> areasAt(const AreaPlan& plan, const std::vector<cv::Point2d>& points) {
  std::vector<int> areas;
  for (const cv::Point2d& point : points) areas.push_back(areaAt(plan, point, 0));
  return areas;
}

TEST(CorrectPlan, CutsOffWhatALineSeparatesAndNothingBeyond) {
  const AreaPlan plan = twoArms();
  const std::vector<cv::Point2d> points{{0.5, 0.5}, {0.5, 5.5}, {4.5, 5.5}, {7, 1}};
  EXPECT_THAT(areasAt(plan, points), ElementsAre(0, 0, 0, 1));
  for (const auto& [from, to] : {std::pair<cv::Point2d, cv::Point2d>{{0, 3}, {1, 3}},
                                 {{-0.5, 3}, {1.5, 3.2}},
                                 {{0.4, 3}, {0.6, 3}},  // goes on to the walls
                                 {{1, 3}, {0, 3}}}) {
    const auto cut = corrected(plan, AreaEdit::Kind::split, from, to);
    ASSERT_TRUE(cut) << from;
    EXPECT_EQ(cut->areas.size(), 3U);
    const std::vector<int> areas = areasAt(*cut, points);
    EXPECT_NE(areas[1], areas[0]);
    EXPECT_EQ(areas[2], areas[0]) << "the other arm lies on the same infinite line";
    EXPECT_NEAR(cut->areas[static_cast<std::size_t>(areas[1])].size, 3, 0.3) << "1 m × 3 m";
  }
  const auto crooked = corrected(plan, AreaEdit::Kind::split, {0, 2}, {1, 4});
  ASSERT_TRUE(crooked);
  EXPECT_THAT(areasAt(*crooked, {{0.1, 2.6}, {0.9, 3.4}}), testing::Not(ElementsAre(0, 0)));
}

TEST(CorrectPlan, RefusesWhatChangesNothing) {
  AreaPlan plan = twoArms();
  const auto splits = [&plan](const cv::Point2d& from, const cv::Point2d& to) {
    return corrected(plan, AreaEdit::Kind::split, from, to).has_value();
  };
  EXPECT_FALSE(splits({2, 3}, {3, 3})) << "in no area";
  EXPECT_FALSE(splits({0.5, 3}, {0.5, 3}));
  EXPECT_FALSE(splits({1e300, 0}, {-1e300, 1e300}));
  plan.areaOf(cv::Rect(0, 50, 50, 10)) = 0;
  EXPECT_FALSE(splits({0, 3}, {1, 3})) << "there is a way around";
  EXPECT_TRUE(splits({-4, 3}, {5, 3})) << "now there is none";
  plan.areaOf(cv::Rect(7, 28, 2, 4)) = -1;
  EXPECT_TRUE(splits({-4.1, 3}, {5.1, 3})) << "across a table";
  EXPECT_FALSE(corrected(plan, AreaEdit::Kind::merge, {0.5, 1}, {0.5, 2}));
  EXPECT_FALSE(corrected(plan, AreaEdit::Kind::merge, {0.5, 1}, {5.5, 1}));
  EXPECT_EQ(corrected(plan, AreaEdit::Kind::merge, {0.5, 1}, {7, 1})->areas.size(), 1U);
}

TEST(CorrectPlan, KnowsTheAreasOfFramesThatAreLeft) {
  const AreaPlan plan = twoArms();
  FramePoses frames;
  frames.add(Pose::planar(0.5, 0.5, 0));
  frames.skipTo(10);
  frames.add(Pose::planar(7, 1, 0));
  frames.skipTo(20);
  frames.add(std::nullopt);  // pose of a drive whose first frame was left out
  frames.skipTo(30);
  frames.add(Pose::planar(0.5, 5, 0));
  frames.add(std::nullopt);
  const std::vector<std::size_t> starts{0, 19};
  const auto planned =
      correctPlan(plan, {AreaEdit::Kind::split, {0, 3}, {1, 3}}, {frames, starts}, WordMap(plan.floor, 1),
                  Vocabulary(std::vector<std::string>{"wall"}), {0.1F});
  ASSERT_TRUE(planned);
  EXPECT_THAT(planned->frames, ElementsAre(0, 10, 20, 30, 31));
  // The cut arm has most frames; of the others the first comes first.
  EXPECT_THAT(planned->areaOfFrame, ElementsAre(1, 2, 0, 0, 0));
  EXPECT_EQ(planned->plan.areas[0].frames, 3U);
}

}  // namespace
}  // namespace estancia
