// Edits of areas: names, merges, splits.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

#include "estancia/core/error.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::FlatDrive;
using test::sampleWorld;
using test::ScratchFolder;

/// Maps the drive's frames up to `end`, beginning or going on.
void mapFlat(std::size_t end, const fs::path& file) {
  const FlatDrive drive;
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

constexpr std::size_t framesOfFlat = 64;

TEST(EditAreas, NamesMergesAndSplitsOutliveAnotherSegmentation) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  mapFlat(50, file);
  const std::string bedroom = "Ana's \"room\"";
  nameArea(file, "0", "hall");
  nameArea(file, std::to_string(readWorld(file).areaOfFrame[0]), bedroom);
  mapFlat(framesOfFlat, file);
  WorldMap world = readWorld(file);
  EXPECT_EQ(world.findArea(world.areaOfFrame[0])->displayName(), bedroom);

  mergeAreas(file, bedroom, std::to_string(world.areaOfFrame[20]));
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 2U);
  EXPECT_EQ(world.areaOfFrame[0], world.areaOfFrame[20]);

  splitArea(file, {2, 0.2}, {2, 3.8});
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 3U);
  EXPECT_NE(areaAt(*world.plan, {1, 2}, 0.1), areaAt(*world.plan, {3, 2}, 0.1));
  mapFlat(framesOfFlat, file);  // finds them anew, with all edits
  const WorldMap again = readWorld(file);
  EXPECT_EQ(again.areaOfFrame, world.areaOfFrame);
  EXPECT_EQ(cv::norm(again.plan->areaOf, world.plan->areaOf, cv::NORM_INF), 0);
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    EXPECT_EQ(again.areas[i].displayName(), world.areas[i].displayName());
    EXPECT_EQ(again.areas[i].name, world.areas[i].name) << "by the same words";
  }
}

TEST(EditAreas, RefuseWhatCannotBeDone) {
  const ScratchFolder folder;
  const fs::path file = folder / "home.estancia";
  test::writeWorld(sampleWorld(), file);
  nameArea(file, "0", "Workshop");
  for (const char* name : {" ", "\t\n", "12", " 7 ", "-3", "workshop", " Workshop"})
    EXPECT_THAT([&] { nameArea(file, "1", name); }, FailsWith(ErrorCode::invalidInput)) << name;
  EXPECT_THAT([&] { nameArea(file, "cellar", "x"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { mergeAreas(file, "0", "0"); }, FailsWith(ErrorCode::invalidInput));
  for (const auto& line : {std::pair<cv::Point2d, cv::Point2d>{{50, 50}, {51, 51}},
                           {{1e300, 1e300}, {1e300, 1e300}},
                           {{2, 2}, {2, 2}}})
    EXPECT_THAT([&] { splitArea(file, line.first, line.second); }, FailsWith(ErrorCode::invalidInput))
        << line.first;
  nameArea(file, "0", "workshop");  // its own name in another case
  nameArea(file, "1", "room 12");
  EXPECT_EQ(readWorld(file).areas[0].displayName(), "workshop");
  EXPECT_EQ(readWorld(file).areas[1].displayName(), "room 12");
  nameArea(file, "1", "");
  EXPECT_EQ(readWorld(file).areas[1].givenName, "");
}

TEST(EditAreas, MergeOnlyWhatTouches) {
  const ScratchFolder folder;
  const fs::path file = folder / "home.estancia";
  test::writeWorld(sampleWorld(), file);
  EXPECT_THAT([&] { mergeAreas(file, "0", "3"); }, FailsWith(ErrorCode::invalidInput));
  mergeAreas(file, "0", "1");
  const WorldMap merged = readWorld(file);
  EXPECT_EQ(merged.areas.size(), 3U);
  const int kitchen = areaAt(*merged.plan, {1, 1}, 0);
  EXPECT_EQ(areaAt(*merged.plan, {5, 1}, 0), kitchen);
  EXPECT_EQ(merged.objects[0].area, kitchen);
  EXPECT_EQ(merged.objects[5].area, kitchen) << "what was in the bathroom";
  EXPECT_EQ(merged.objects[3].area, areaAt(*merged.plan, {7, 7}, 0));
  EXPECT_EQ(merged.objects[1].onObject, 0);
  EXPECT_EQ(merged.objects[1].words.size(), 2U) << "nothing else has changed";
}

TEST(EditAreas, StopWhenAsked) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const auto interruptedRun = [&file] {
    mapFlat(framesOfFlat, file);
    const std::vector<int> before = readWorld(file).areaOfFrame;
    std::signal(SIGINT, SIG_DFL);  // who runs the tests in the background has it ignored
    catchInterrupts();
    std::raise(SIGINT);
    try {
      splitArea(file, {2, 0.2}, {2, 3.8});
    } catch (const Interrupted&) {
      const WorldMap after = readWorld(file);
      std::_Exit(after.edits.empty() && after.areaOfFrame == before ? 3 : 5);
    }
    std::_Exit(4);
  };
  EXPECT_EXIT(interruptedRun(), testing::ExitedWithCode(3), "");
}

}  // namespace
}  // namespace estancia
