// Areas of a made-up flat of two rooms and a corridor, driven through by a camera with depth.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/areas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "support/errors.hpp"
#include "support/flat_drive.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::flatDepth;
using test::FlatDrive;
using test::lookingAt;
using test::smallCamera;

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

}  // namespace
}  // namespace estancia
