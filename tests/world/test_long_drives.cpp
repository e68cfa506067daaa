// A drive of which only each n-th frame is read, and what its areas are called while it lasts.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "estancia/topology/map.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/world_map.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FlatDrive;
using test::ScratchFolder;

fs::path mapOf(const FlatDrive& drive, const ScratchFolder& folder) {
  const fs::path file = folder / "flat.estancia";
  test::mapUpTo(drive, drive.labeledInWords(), drive.size(), file);
  return file;
}

TEST(LongDrives, AreReadByEachNthFrame) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = mapOf(drive, folder);
  const WorldMap whole = readWorld(file);
  EXPECT_FALSE(whole.places.isThinned());
  for (const std::size_t most : {64U, 63U, 20U, 7U, 1U, 0U}) {
    const WorldMap some = readWorld(file, most);
    const std::size_t stride =
        some.places.frames.size() > 1 ? some.places.frames[1].number : whole.places.frames.size();
    EXPECT_LE(some.places.frames.size(), std::max<std::size_t>(1, most));
    EXPECT_GE(2 * some.places.frames.size(), most) << "as many as half of them at least";
    ASSERT_EQ(some.areaOfFrame.size(), some.places.frames.size());
    ASSERT_EQ(some.zoneOfFrame.size(), some.places.frames.size());
    for (std::size_t i = 0; i < some.places.frames.size(); ++i) {
      EXPECT_EQ(some.places.frames[i].name, whole.places.frames[i * stride].name);
      EXPECT_EQ(some.places.frames[i].node, whole.places.frames[i * stride].node);
      EXPECT_EQ(some.areaOfFrame[i], whole.areaOfFrame[i * stride]);
      EXPECT_EQ(some.zoneOfFrame[i], whole.zoneOfFrame[i * stride]);
      EXPECT_EQ(some.places.decisions.at(i).node, whole.places.decisions[i * stride].node);
    }
    ASSERT_EQ(some.places.transitions.size(), whole.places.transitions.size());
    for (std::size_t i = 0; i < whole.places.transitions.size(); ++i)
      EXPECT_EQ(some.places.transitions[i].firstFrame, whole.places.transitions[i].firstFrame / stride);
    EXPECT_EQ(some.places.nodes.size(), whole.places.nodes.size());
    EXPECT_EQ(some.areas.size(), whole.areas.size());
  }
}

TEST(LongDrives, KeepTheFramesOfObjects) {
  const ScratchFolder folder;
  const fs::path file = folder / "sample.estancia";
  test::writeWorld(test::sampleWorld(), file);
  const WorldMap whole = readWorld(file), some = readWorld(file, whole.places.frames.size() / 2);
  ASSERT_EQ(some.places.frames.at(1).number, 2U);
  ASSERT_EQ(some.objects.size(), whole.objects.size());
  for (std::size_t i = 0; i < whole.objects.size(); ++i) {
    EXPECT_EQ(some.objects[i].firstFrame, whole.objects[i].firstFrame / 2);
    EXPECT_EQ(some.objects[i].lastFrame, whole.objects[i].lastFrame / 2);
    EXPECT_EQ(some.objects[i].bestFrame, whole.objects[i].bestFrame / 2);
    EXPECT_EQ(some.objects[i].views, whole.objects[i].views);
  }
}

TEST(GrowingRooms, AreNamedAsTheFinishedMapNamesThem) {
  const ScratchFolder folder;
  const fs::path file = mapOf(FlatDrive(), folder);
  WorldMap growing = readWorld(file);
  for (const WorldArea& area : growing.areas) EXPECT_EQ(area.roomName, "");
  GrowingRooms rooms;
  rooms.name(file, growing);
  ASSERT_TRUE(renewRoomsByNames(file));
  const WorldMap finished = readWorld(file);
  ASSERT_EQ(growing.areas.size(), finished.areas.size());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < finished.areas.size(); ++i) {
    EXPECT_EQ(growing.areas[i].displayName(), finished.areas[i].displayName());
    names.push_back(finished.areas[i].roomName);
  }
  EXPECT_THAT(names, testing::Contains("bedroom"));

  WorldMap fewer = readWorld(file, 20);
  rooms.name(file, fewer);
  for (std::size_t i = 0; i < finished.areas.size(); ++i)
    EXPECT_EQ(fewer.areas[i].displayName(), finished.areas[i].displayName());
}

TEST(LongDrives, NameTheirRoomsBySomeFrames) {
  const ScratchFolder folder;
  const fs::path file = mapOf(FlatDrive(), folder);
  nameRoomsByNames(file);
  const WorldMap all = readWorld(file);
  nameRoomsByNames(file, {}, 20);
  const WorldMap some = readWorld(file);
  ASSERT_TRUE(some.places.predictions);
  const DescriptorMatrix& rooms = some.places.predictions->probabilities;
  ASSERT_EQ(rooms.size(), some.places.frames.size());
  for (std::size_t i = 0; i < rooms.size(); ++i)
    EXPECT_NEAR(std::reduce(rooms.row(i).begin(), rooms.row(i).end()), i % 4 == 0 ? 1 : 0, 1e-5) << i;
  for (const RoomEvidence& told : some.places.predictions->evidence) EXPECT_EQ(told.image % 4, 0U);
  ASSERT_EQ(some.areas.size(), all.areas.size());
  for (std::size_t i = 0; i < all.areas.size(); ++i)
    EXPECT_EQ(some.areas[i].displayName(), all.areas[i].displayName());
  EXPECT_EQ(readWorld(file, 20).areas.front().displayName(), all.areas.front().displayName());
}

TEST(GrowingRooms, LeaveTheNamesOfATrainedClassifier) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = mapOf(drive, folder);
  RoomPredictions trained{"svm", {"den", "attic"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < drive.size(); ++i) trained.probabilities.append(LexicalDescriptor{0.9F, 0.1F});
  writeRoomPredictions(trained, file);
  WorldMap growing = readWorld(file);
  const std::string before = growing.areas.front().displayName();
  GrowingRooms().name(file, growing);
  EXPECT_THAT(before, testing::HasSubstr("den"));
  EXPECT_EQ(growing.areas.front().displayName(), before);
}

}  // namespace
}  // namespace estancia
