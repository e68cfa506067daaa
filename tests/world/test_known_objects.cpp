// Objects that are known, and long drives of which only some frames are read.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/known_objects.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "estancia/core/pose.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/export_world.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/sample_world.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::desk;
using test::FailsWith;
using test::FlatDrive;
using test::ScratchFolder;
using test::Shape;
using test::ShapeDrive;
using test::shelf;
using test::surfaceOf;

/// Beginning or going on.
WorldMap mapWith(const ShapeDrive& drive, std::size_t end, const fs::path& file,
                 const std::shared_ptr<const KnownObjects>& known) {
  return test::mapShapes(drive, end, file, [&](WorldMapper& world) {
    if (known) world.recognize(known);
  });
}

std::shared_ptr<const KnownObjects> knownBy(const std::vector<ModelFile>& files) {
  return std::make_shared<const KnownObjects>(files);
}

void expectDesk(const WorldMap& world) {
  ASSERT_EQ(world.objects.size(), 1U);
  const WorldObject& object = world.objects.front();
  ASSERT_TRUE(object.known);
  EXPECT_EQ(object.displayName(), "desk");
  EXPECT_GT(object.known->confidence, 0.6);
  EXPECT_EQ(object.probability(), object.known->confidence);
  const cv::Affine3d error = ShapeDrive::placeOfShape().inv() * rigidOf(object.known->pose);
  EXPECT_LT(cv::norm(error.translation()), 0.02);
  EXPECT_LT(angleOf(error) * 180 / std::numbers::pi, 2);
}

TEST(KnownObjects, GiveNamesAndPosesToTheObjectsThatTheyAre) {
  const ScratchFolder folder;
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  writeCloud(surfaceOf(shelf), folder / "shelf.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}, {"shelf", folder / "shelf.ply"}});
  const WorldMap world = mapWith(ShapeDrive(desk), 12, folder / "map.estancia", known);
  expectDesk(world);
  const WorldAnswers answers = askWorld(world, "Desk");
  ASSERT_EQ(answers.objects.size(), 1U);
  EXPECT_TRUE(answers.objects[0].isKnown);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_EQ(answers.objects[0].probability, world.objects[0].known->confidence);
  EXPECT_TRUE(answers.places.empty());
  EXPECT_THAT([&] { askWorld(world, "shelf"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT(findNearNames(world, "desc"), testing::Contains("desk"));
  const auto json = toJson("desk", answers, world)["objects"][0];
  EXPECT_EQ(json["name"], "desk");
  EXPECT_EQ(json["recognized"], true);
  EXPECT_NEAR(json["known"]["position"][0].get<double>(), 0.3, 0.02);
  EXPECT_EQ(json["known"]["orientation"].size(), 4U);
}

TEST(KnownObjects, AreNotFoundWhereTheyAreNot) {
  const ScratchFolder folder;
  writeCloud(surfaceOf(shelf), folder / "shelf.ply");
  const WorldMap world =
      mapWith(ShapeDrive(desk), 12, folder / "map.estancia", knownBy({{"shelf", folder / "shelf.ply"}}));
  ASSERT_EQ(world.objects.size(), 1U);
  EXPECT_FALSE(world.objects[0].known);
  sqlite::Database database(folder / "map.estancia", sqlite::Database::Mode::read);
  EXPECT_EQ(database.number("SELECT count(*) FROM recognitions"), 3) << "the best views";
  EXPECT_EQ(database.number("SELECT count(x) FROM recognitions"), 0);
}

TEST(KnownObjects, StayFoundAndMayBeGivenAfterTheDrive) {
  const ScratchFolder folder;
  const ShapeDrive drive(desk);
  const fs::path file = folder / "map.estancia";
  EXPECT_FALSE(mapWith(drive, 8, file, nullptr).objects.at(0).known);
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}});
  requestInterrupt();
  EXPECT_FALSE(mapWith(drive, 8, file, known).objects.at(0).known) << "who stops it waits for no recognition";
  EXPECT_TRUE(takeInterrupt());
  expectDesk(mapWith(drive, 8, file, known));
  expectDesk(mapWith(drive, 12, file, nullptr));
  const auto tries = [&file] {
    return sqlite::Database(file, sqlite::Database::Mode::read).number("SELECT count(*) FROM recognitions");
  };
  const std::int64_t before = tries();
  expectDesk(mapWith(drive, 12, file, known));
  EXPECT_EQ(tries(), before) << "it is found already";
  writeCloud(surfaceOf(shelf), folder / "desk.ply");
  EXPECT_FALSE(mapWith(drive, 12, file, knownBy({{"desk", folder / "desk.ply"}})).objects.at(0).known)
      << "another cloud of that name";
}

TEST(KnownObjects, SayWhichCloudCannotBeUsed) {
  const ScratchFolder folder;
  const auto known = [](const fs::path& file) { return [file] { KnownObjects({{"desk", file}}); }; };
  EXPECT_THAT(known(folder / "missing.ply"), FailsWith(ErrorCode::fileNotFound));
  PointCloud few = surfaceOf(desk);
  few.points.resize(5), few.normals.resize(5), few.width = 5;
  writeCloud(few, folder / "few.ply");
  EXPECT_THAT(known(folder / "few.ply"), FailsWith(ErrorCode::insufficientData));
  writeCloud(surfaceOf(desk, 1000), folder / "millimeters.ply");
  EXPECT_THAT(known(folder / "millimeters.ply"), FailsWith(ErrorCode::invalidInput));
  writeCloud(surfaceOf({{{{0, 0, 0}, {0.5, 0.5, 0.001}}}}), folder / "sheet.ply");
  EXPECT_THAT(known(folder / "sheet.ply"), FailsWith(ErrorCode::invalidInput));
  writeCloud(surfaceOf(desk), folder / "desk.ply");
  const std::vector<ModelFile> twice(2, {"desk", folder / "desk.ply"});
  EXPECT_THAT([&] { KnownObjects objects(twice); }, FailsWith(ErrorCode::invalidOption));
}

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
