// A drive of which only each n-th frame is read, and what its areas are called while it lasts.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/export_world.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"
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

/// The sample world driven in small steps: `steps` frames from each of its frames to the next.
WorldMap slowWorld(std::size_t steps) {
  WorldMap world = test::sampleWorld();
  std::vector<MappedFrame> frames;
  std::vector<Decision> decisions;
  for (std::size_t i = 0; i < world.places.frames.size(); ++i)
    for (std::size_t step = 0; step < steps; ++step) {
      const MappedFrame &from = world.places.frames[i],
                        &to = world.places.frames[std::min(i + 1, world.places.frames.size() - 1)];
      const double share = static_cast<double>(step) / static_cast<double>(steps);
      MappedFrame frame = test::sampleFrame(i * steps + step, from.node, 0, 0, 0);
      frame.pose = from.pose;
      frame.pose->x += share * (to.pose->x - from.pose->x);
      frame.pose->y += share * (to.pose->y - from.pose->y);
      frames.push_back(frame);
      decisions.push_back(world.places.decisions[i]);
      decisions.back().frame = frame.number;
    }
  world.places.frames = frames;
  world.places.decisions = decisions;
  for (Node& node : world.places.nodes) node.frames *= steps;
  for (Transition& transition : world.places.transitions)
    transition.firstFrame = std::min(transition.firstFrame * steps, frames.size() - 1);
  for (WorldObject& object : world.objects)
    for (std::size_t WorldObject::*frame :
         {&WorldObject::firstFrame, &WorldObject::lastFrame, &WorldObject::bestFrame})
      object.*frame = object.*frame * steps + 1;
  world.areaOfFrame.clear();
  for (const MappedFrame& frame : frames) world.areaOfFrame.push_back(frame.node);
  return world;
}

TEST(LongDrives, KeepTheFramesThatTheirLayersName) {
  const ScratchFolder folder;
  const fs::path file = folder / "slow.estancia";
  test::writeWorld(slowWorld(50), file);
  const WorldMap whole = readWorld(file);
  ASSERT_EQ(whole.places.frames.size(), 400U);
  for (const std::size_t most : {200U, 3U}) {
    const WorldMap some = readWorld(file, most);
    EXPECT_TRUE(some.places.isThinned());
    EXPECT_LE(some.places.frames.size(), most + 3 * whole.places.nodes.size() + 12);
    const auto numberOf = [&](std::size_t frame) { return some.places.frames.at(frame).number; };
    std::map<int, int> framesOf;
    for (std::size_t i = 0; i < some.places.frames.size(); ++i) {
      const MappedFrame& same = whole.places.frames[numberOf(i)];
      EXPECT_EQ(some.places.frames[i].name, same.name);
      EXPECT_EQ(some.places.frames[i].node, same.node);
      EXPECT_EQ(some.areaOfFrame.at(i), whole.areaOfFrame[numberOf(i)]);
      ++framesOf[same.node];
    }
    for (const Node& node : whole.places.nodes) EXPECT_GE(framesOf[node.id], 3);
    EXPECT_TRUE(some.places.decisions.empty());
    ASSERT_EQ(some.objects.size(), whole.objects.size());
    for (std::size_t i = 0; i < whole.objects.size(); ++i) {
      EXPECT_EQ(numberOf(some.objects[i].firstFrame), whole.objects[i].firstFrame);
      EXPECT_EQ(numberOf(some.objects[i].lastFrame), whole.objects[i].lastFrame);
      EXPECT_EQ(numberOf(some.objects[i].bestFrame), whole.objects[i].bestFrame);
      EXPECT_EQ(some.objects[i].views, whole.objects[i].views);
    }
  }
}

TEST(LongDrives, AnswerAsIfAllFramesWereRead) {
  const ScratchFolder folder;
  const fs::path file = folder / "slow.estancia";
  test::writeWorld(slowWorld(50), file);
  const WorldMap whole = readWorld(file);
  WorldMap some = readWorld(file, 40);
  some.places.visits = readVisits(file);
  const auto answer = [](const WorldMap& world, const std::string& words) {
    return toJson(words, askWorld(world, words, 5, 5), world).dump();
  };
  for (const char* words : {"umbrella", "coffee mug", "kitchen", "folding chair"})
    EXPECT_EQ(answer(some, words), answer(whole, words));
  for (const char* to : {"umbrella", "corridor", "coffee mug"}) {
    const WorldRoute known = routeInWorld(whole, 0, to, {}, {}), found = routeInWorld(some, 0, to, {}, {});
    EXPECT_EQ(found.route.nodes, known.route.nodes) << to;
    EXPECT_NEAR(found.route.cost, known.route.cost, 0.3) << to;
  }
  for (const auto& [format, explanation] : worldFormats())
    EXPECT_EQ(exportWorld(some, format).find("frame_ranges") != std::string::npos, listsFrames(format))
        << format;
  EXPECT_EQ(nlohmann::json::parse(exportWorld(some, "json"))["places"][0]["frame_ranges"],
            nlohmann::json::parse("[[0, 149]]"));
  EXPECT_EQ(nlohmann::json::parse(exportWorld(some, "rooms"))["rooms"][3]["places"][0]["frame_ranges"],
            nlohmann::json::parse("[[200, 349]]"));
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

  RoomPredictions trained{"svm", {"den", "attic"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < finished.places.frames.size(); ++i)
    trained.probabilities.append(LexicalDescriptor{0.9F, 0.1F});
  writeRoomPredictions(trained, file);
  WorldMap classified = readWorld(file);
  GrowingRooms().name(file, classified);
  EXPECT_EQ(classified.areas.front().roomName, readWorld(file).areas.front().roomName)
      << "the names of a trained classifier stay";
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
  ASSERT_EQ(rooms.size(), some.places.frames.size() - 3) << "up to the last that was predicted";
  for (std::size_t i = 0; i < rooms.size(); ++i)
    EXPECT_NEAR(std::reduce(rooms.row(i).begin(), rooms.row(i).end()), i % 4 == 0 ? 1 : 0, 1e-5) << i;
  for (const RoomEvidence& told : some.places.predictions->evidence) EXPECT_EQ(told.image % 4, 0U);
  ASSERT_EQ(some.areas.size(), all.areas.size());
  for (std::size_t i = 0; i < all.areas.size(); ++i)
    EXPECT_EQ(some.areas[i].displayName(), all.areas[i].displayName());
  EXPECT_EQ(readWorld(file, 20).areas.front().displayName(), all.areas.front().displayName());
}

}  // namespace
}  // namespace estancia
