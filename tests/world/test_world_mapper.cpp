// A map that keeps areas beside its places, in one pass, through interruptions and corrections.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/world_mapper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "estancia/topology/sqlite.hpp"
#include "estancia/world/edit_areas.hpp"
#include "estancia/world/observation.hpp"
#include "estancia/world/world_map.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::FlatDrive;
using test::ScratchFolder;

/// Maps the drive's frames up to `end`, beginning or going on.
void mapUpTo(const FlatDrive& drive, std::size_t end, const fs::path& file) {
  const DescriptorSequence labeled = drive.labeled();
  MappingSession session =
      fs::exists(file) ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
                       : MappingSession::create(file, labeled.vocabulary, labeled.model, MapperOptions{});
  WorldMapper world(session);
  for (std::size_t i = session.frames(); i < end; ++i) {
    world.observe(drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i),
                  *drive.intrinsics());
    session.add(drive.frame(i), labeled.descriptors.row(i));
  }
  session.finish();
  world.finish();
}

WorldMap mapOf(const FlatDrive& drive, const fs::path& file) {
  mapUpTo(drive, drive.size(), file);
  return readWorld(file);
}

void expectSame(const WorldMap& a, const WorldMap& b) {
  EXPECT_EQ(a.areaOfFrame, b.areaOfFrame);
  ASSERT_EQ(a.areas.size(), b.areas.size());
  for (std::size_t i = 0; i < a.areas.size(); ++i) {
    EXPECT_EQ(a.areas[i].displayName(), b.areas[i].displayName());
    EXPECT_EQ(a.areas[i].size, b.areas[i].size);
    EXPECT_EQ(a.areas[i].outline, b.areas[i].outline);
  }
  ASSERT_TRUE(a.plan && b.plan);
  EXPECT_EQ(cv::norm(a.plan->areaOf, b.plan->areaOf, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.plan->walls, b.plan->walls, cv::NORM_INF), 0);
}

TEST(WorldMapper, FindsTheAreasThatTheWholeDriveShows) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const WorldMap world = mapOf(drive, folder / "flat.estancia");
  ASSERT_EQ(world.areas.size(), 3U);
  std::set<std::pair<std::string, int>> pairs;
  for (std::size_t i = 0; i < drive.size(); ++i) pairs.emplace(drive.frame(i).room, world.areaOfFrame[i]);
  EXPECT_EQ(pairs.size(), 3U);
  const Areas whole = findAreas(drive, drive.labeled());
  EXPECT_EQ(world.areaOfFrame, whole.zones.zoneOf);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(world.areas[i].name, whole.areas[i].name);
}

TEST(WorldMapper, GoesOnWhereItStoppedAsIfItHadNotStopped) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const WorldMap unbroken = mapOf(drive, folder / "unbroken.estancia");
  const fs::path file = folder / "broken.estancia";
  for (const std::size_t stop : {1U, 2U, 17U, 40U, 64U}) mapUpTo(drive, stop, file);
  expectSame(readWorld(file), unbroken);
}

TEST(WorldMapper, KeepsTheLayersOfAllFramesConsistentAtAnyTime) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  for (std::size_t end = 4; end <= drive.size(); end += 4) {
    mapUpTo(drive, end, file);
    const WorldMap world = readWorld(file);
    ASSERT_EQ(world.areaOfFrame.size(), end);
    for (std::size_t i = 0; i < end; ++i) {
      ASSERT_NE(world.findArea(world.areaOfFrame[i]), nullptr) << i;
      const PlanarPose at = world.plan->floor.project(*world.places.frames[i].pose);
      EXPECT_EQ(areaAt(*world.plan, {at.x, at.y}, 0.5), world.areaOfFrame[i]) << i << " of " << end;
    }
  }
}

TEST(WorldMapper, LeavesOutViewsFromWhereItHasJustLooked) {
  const ScratchFolder folder;
  FlatDrive drive;
  for (Frame& frame : drive.frames_) frame.pose = drive.frames_[0].pose;
  mapUpTo(drive, drive.size(), folder / "still.estancia");
  sqlite::Database database(folder / "still.estancia", sqlite::Database::Mode::read);
  EXPECT_EQ(database.number("SELECT count(*) FROM observations"), 1);
}

TEST(WorldMapper, HasNoAreasWithoutPosesOrDepth) {
  const ScratchFolder folder;
  FlatDrive drive;
  for (Frame& frame : drive.frames_) frame.pose.reset();
  EXPECT_TRUE(mapOf(drive, folder / "unposed.estancia").areas.empty());
  FlatDrive dark;
  dark.zero = [](std::size_t) { return true; };
  EXPECT_FALSE(mapOf(dark, folder / "dark.estancia").plan.has_value());
}

TEST(WorldMapper, RefusesDepthAndCamerasThatAreNone) {
  EXPECT_THAT([] { observe(cv::Mat(4, 4, CV_16U), test::smallCamera()); },
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { observe(cv::Mat(4, 4, CV_32F), CameraIntrinsics{}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(EditAreas, NamesMergesAndSplitsOutliveAnotherSegmentation) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  mapUpTo(drive, 50, file);
  const std::string bedroom = "Ana's \"room\"";
  nameArea(file, "0", "hall");
  nameArea(file, std::to_string(readWorld(file).areaOfFrame[0]), bedroom);
  mapUpTo(drive, drive.size(), file);
  WorldMap world = readWorld(file);
  EXPECT_EQ(world.findArea(world.areaOfFrame[0])->displayName(), bedroom);

  mergeAreas(file, bedroom, std::to_string(world.areaOfFrame[63]));
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 2U);
  EXPECT_EQ(world.areaOfFrame[0], world.areaOfFrame[63]);

  splitArea(file, {2, 0.2}, {2, 3.8});
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 3U);
  EXPECT_NE(areaAt(*world.plan, {1, 2}, 0.1), areaAt(*world.plan, {3, 2}, 0.1));
  mapUpTo(drive, drive.size(), file);
  expectSame(readWorld(file), world);
}

TEST(EditAreas, SayWhichAreasThereAre) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  mapUpTo(drive, drive.size(), file);
  EXPECT_THAT([&] { nameArea(file, "cellar", "x"); }, FailsWith(ErrorCode::unknownName, "stove"));
  EXPECT_THAT([&] { mergeAreas(file, "0", "0"); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { splitArea(file, {50, 50}, {51, 51}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { splitArea(file, {2, 2}, {2, 2}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_EQ(readWorld(file).edits.size(), 0U);
}

TEST(WorldStore, RefusesDamagedLayers) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path whole = folder / "whole.estancia";
  mapUpTo(drive, drive.size(), whole);
  for (const std::string damage :
       {"UPDATE floor SET columns = 1000000000", "UPDATE floor SET rows = rows + 1",
        "UPDATE floor SET cell = 0", "UPDATE floor SET areas = x'00'",
        "UPDATE areas SET outline = '[[1]]' WHERE id = 0", "UPDATE frame_areas SET area = 77",
        "DELETE FROM areas WHERE id = 0", "INSERT INTO area_edits VALUES(1, 'paint', 0, 0, 0, 0, '')"}) {
    const fs::path file = folder / "damaged.estancia";
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    sqlite::Database(file, sqlite::Database::Mode::write).run(damage);
    EXPECT_THAT([&] { readWorld(file); }, FailsWith(ErrorCode::corruptFile)) << damage;
  }
  const fs::path file = folder / "observation.estancia";
  fs::copy_file(whole, file);
  sqlite::Database(file, sqlite::Database::Mode::write).run("UPDATE observations SET seen = x'0011'");
  EXPECT_THAT([&] { mapUpTo(drive, drive.size(), file); }, FailsWith(ErrorCode::corruptFile));
}

}  // namespace
}  // namespace estancia
