// Areas of a map: found, numbered, and corrected by lines.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/areas.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/plan_areas.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/core/vocabulary.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::flatDepth;
using test::FlatDrive;
using test::lookingAt;
using test::smallCamera;
using testing::ElementsAre;

const Area& areaOf(const Areas& areas, const std::string& room) {
  for (const Zone& zone : areas.zones.zones)
    if (zone.room == room) return areas.areas[zone.id];
  throw Error(ErrorCode::unknownName, room);
}

void expectTheFlat(const Areas& areas) {
  ASSERT_EQ(areas.zones.zones.size(), 3U);
  for (const Zone& zone : areas.zones.zones) EXPECT_EQ(zone.roomShare, 1) << zone.room;
  EXPECT_NE(areaOf(areas, "bedroom").name.find("bed"), std::string::npos);
  EXPECT_NE(areaOf(areas, "kitchen").name.find("stove"), std::string::npos);
  EXPECT_NEAR(areaOf(areas, "bedroom").size, 16, 1.5);
}

TEST(Areas, AreTheRoomsOfAFlatWithTheirWords) {
  const FlatDrive drive;
  const Areas areas = findAreas(drive, drive.labeled());
  expectTheFlat(areas);
  const Area& bedroom = areaOf(areas, "bedroom");
  EXPECT_NEAR(bedroom.center.x, 2.5, 0.6);
  EXPECT_NEAR(bedroom.center.y, 2.5, 0.6);
  EXPECT_EQ(bedroom.frames, 16U);
  EXPECT_NEAR(cv::contourArea(std::vector<cv::Point2f>(bedroom.outline.begin(), bedroom.outline.end()), true),
              bedroom.size, 1);
  for (std::size_t i = 0; i < areas.areas.size(); ++i) EXPECT_EQ(areas.areas[i].id, static_cast<int>(i));
}

TEST(Areas, BearATiltedCameraAndMissingDepthAndPoses) {
  const FlatDrive tilted(-0.35);
  expectTheFlat(findAreas(tilted, tilted.labeled()));
  FlatDrive half;
  half.dark = [](std::size_t i) { return i % 4 == 0; };
  half.zero = [](std::size_t i) { return i % 4 == 2; };
  expectTheFlat(findAreas(half, half.labeled()));
  FlatDrive unposed;
  for (const std::size_t i : {0U, 1U, 20U, 63U}) unposed.frames_[i].pose.reset();
  expectTheFlat(findAreas(unposed, unposed.labeled()));
}

TEST(Areas, AreTheSameInMapsWithAnotherAxisUp) {
  FlatDrive drive;
  const DescriptorSequence upright = drive.labeled();
  const Areas expected = findAreas(drive, upright);
  // y down, z forward: the first camera's axes. The scene stays where it is.
  DescriptorSequence turned = upright;
  const cv::Affine3d first = rigidOf(*drive.frames_[0].pose).inv();
  for (Frame& frame : turned.frames) frame.pose = poseOf(first * rigidOf(*frame.pose));
  const Areas areas = findAreas(drive, turned);
  EXPECT_EQ(areas.zones.zoneOf, expected.zones.zoneOf);
}

TEST(Areas, HaveTheirCentersHoweverFarApart) {
  FlatDrive drive;
  DescriptorSequence apart = drive.labeled();
  for (std::size_t i = 48; i < 64; ++i) apart.frames[i].pose->x += 4000;  // the kitchen
  const Areas areas = findAreas(drive, apart);
  expectTheFlat(areas);
  EXPECT_NEAR(areaOf(areas, "bedroom").center.x, 2.5, 0.6);
  EXPECT_NEAR(areaOf(areas, "kitchen").center.x, 4006.5, 1.5);
}

TEST(Areas, AreGivenUpWhenAsked) {
  const FlatDrive drive;
  requestInterrupt();
  EXPECT_THAT([&] { findAreas(drive, drive.labeled()); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
}

TEST(Areas, SayWhatIsMissing) {
  FlatDrive drive;
  DescriptorSequence unposed = drive.labeled();
  for (Frame& frame : unposed.frames) frame.pose.reset();
  EXPECT_THAT([&] { findAreas(drive, unposed); }, FailsWith(ErrorCode::insufficientData));
  drive.zero = [](std::size_t) { return true; };
  EXPECT_THAT([&] { findAreas(drive, drive.labeled()); }, FailsWith(ErrorCode::insufficientData));
  drive.dark = drive.zero;
  EXPECT_THAT([&] { findAreas(drive, drive.labeled()); }, FailsWith(ErrorCode::insufficientData));
  AreaOptions options;
  options.cell = -1;
  EXPECT_THAT([&] { findAreas(drive, drive.labeled(), options); }, FailsWith(ErrorCode::invalidOption));
}

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
