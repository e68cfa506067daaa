// Real and rendered drives from end to end.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "apps/json_of.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;

json evaluated(const std::vector<std::string>& arguments) {
  return jsonOf(run({"evaluate", "--json"}, arguments));
}

TEST(RealPlaces, BecomeAMapInWhichTheyAreFoundInAnotherLight) {
  const auto panoramas = findFetched("panoramas"),
             model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(panoramas && model,
                 "the panoramas and the default network are not here; script/bootstrap fetches them");
  const ScratchFolder scratch;
  const std::string map = scratch / "tour.estancia";
  const auto mapped = run({"map", panoramas->string(), "-o", map});
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  const json quality = evaluated({map});
  EXPECT_GE(quality["v_measure"], 0.95);
  EXPECT_GE(quality["purity"], 0.95);
  EXPECT_LE(quality["nodes"], 40);
  const json found = evaluated({map, panoramas->string(), "--turn", "7", "--exposure", "-0.7"});
  EXPECT_GE(found["image_room"], 0.99);
  EXPECT_GE(found["belief_room"], 0.99);
}

TEST(RecordedBags, AreMappedWithoutBeingUnpacked) {
  const auto data = findData("robot_bags");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(data && model, "the bags or the default network are not here");
  const ScratchFolder scratch;
  EXPECT_EQ(jsonOf(run({"map", *data / "camera/soccer_zstd_messages.mcap", "-o", scratch / "bag.estancia",
                        "--json"}))["frames"],
            2);
}

/// Lines of an image of the second drive and those of the first that show the same.
std::set<std::pair<std::size_t, std::size_t>> correspondences(const std::string& csv) {
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  std::istringstream lines(csv.substr(csv.find('\n')));
  for (std::string line; std::getline(lines, line);) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream numbers(line);
    std::size_t query = 0;
    numbers >> query;
    for (std::size_t seen = 0; numbers >> seen;) pairs.emplace(query, seen);
  }
  return pairs;
}

TEST(Corridor, IsDrivenAgainAndRecognized) {
  const auto data = findData("corridor_vpr");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(data && model, "the corridor images or the default network are not here");
  const ScratchFolder scratch;
  setenv("ESTANCIA_CACHE", (scratch / "cache").c_str(), 1);
  const std::string map = scratch / "corridor.estancia";
  const auto mapped = run({"map", *data / "ref", "-o", map});
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  const json filtered = evaluated({map, *data / "query", "--truth", *data / "ground_truth.csv"});
  EXPECT_GE(filtered["recall"], 0.52);
  EXPECT_GE(filtered["belief_recall"], 0.93);

  // Words alone join places only where both drives have been in them.
  const std::string query = scratch / "query.estancia", merged = scratch / "merged.estancia";
  ASSERT_EQ(run({"map", *data / "query", "-o", query}).exitCode, 0);
  ASSERT_EQ(run({"merge", map, query, "-o", merged}).exitCode, 0);
  unsetenv("ESTANCIA_CACHE");
  const TopologicalMap both = readMap(merged);
  ASSERT_EQ(both.frames.size(), 222U);
  const auto truth = correspondences(readFile(*data / "ground_truth.csv"));
  std::set<int> joined, right;
  for (std::size_t i = 111; i < 222; ++i)
    for (std::size_t j = 0; j < 111; ++j)
      if (const int node = both.frames[i].node; node == both.frames[j].node) {
        joined.insert(node);
        if (truth.contains({i - 111, j})) right.insert(node);
      }
  EXPECT_GE(joined.size(), 4U);
  EXPECT_EQ(joined, right);
}

/// Checks the home of the day and the evening; returns the report of the evening's drive.
json expectOneHome(const std::string& map) {
  const json drives = json::parse(run({"drives", map, "--json"}).out)["drives"];
  EXPECT_EQ(drives.size(), 2U);
  const json& evening = drives.back();
  EXPECT_EQ(evening["posed_frames"], 217);
  // Both drives have the poses of one world, which the map did not know.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(evening["alignment"][i], 0, 0.05);
  const WorldMap world = readWorld(map);
  std::vector<std::string> rooms;
  for (const MappedFrame& frame : world.places.frames) rooms.push_back(frame.room);
  EXPECT_GE(measureNamedAgreement(rooms, world.areaOfFrame).agreement.value().vMeasure, 0.9);
  EXPECT_EQ(std::set<int>(world.areaOfFrame.begin(), world.areaOfFrame.end()).size(), 6U);
  return evening;
}

/// Checks, for the places that the map has joined, the frames of both.
void expectJoinedPlacesInOneRoom(const TopologicalMap& map, std::size_t fewest) {
  std::size_t joined = 0;
  const auto roomsOf = [&map](int node) {
    std::set<std::string> rooms;
    for (std::size_t i = 0; i < map.frames.size(); ++i)
      if (map.decisions[i].node == node) rooms.insert(map.frames[i].room);
    return rooms;
  };
  for (const Merge& merge : map.merges) {
    if (merge.frame + 1 < map.frames.size()) continue;  // merge of a map before
    ++joined;
    const std::set<std::string> kept = roomsOf(merge.kept), other = roomsOf(merge.absorbed);
    EXPECT_TRUE(std::ranges::any_of(other, [&](const auto& room) { return kept.contains(room); }))
        << *kept.begin() << " and " << *other.begin();
  }
  EXPECT_GE(joined, fewest);
}

/// What the day's map holds: places, areas and objects, found in one pass.
void expectRoomsAndThings(const std::string& map, const std::filesystem::path& day) {
  const WorldMap world = readWorld(map);
  ASSERT_EQ(world.places.frames.size(), 320U);
  std::map<int, std::map<std::string, int>> rooms;
  for (std::size_t i = 0; i < world.places.frames.size(); ++i) {
    const MappedFrame& frame = world.places.frames[i];
    ASSERT_NE(world.findArea(world.areaOfFrame[i]), nullptr) << frame.name;
    const PlanarPose at = world.plan->floor.project(*frame.pose);
    EXPECT_EQ(areaAt(*world.plan, {at.x, at.y}, 0.5), world.areaOfFrame[i]) << frame.name;
    ++rooms[world.areaOfFrame[i]][frame.room];
  }
  EXPECT_EQ(rooms.size(), 6U);
  EXPECT_GT(world.objects.size(), 60U);
  EXPECT_LT(world.objects.size(), 140U) << "129 things are seen";
  const auto washer = std::ranges::find(world.objects, "washer", &WorldObject::displayName);
  ASSERT_NE(washer, world.objects.end());
  EXPECT_GT(rooms[washer->area]["bathroom"], 0) << "it stands in the bathroom";
  EXPECT_FALSE(readObjectImage(map, washer->id).empty());
  const json asked = json::parse(run({"ask", map, "washer", "--json"}).out)["objects"];
  EXPECT_TRUE(std::ranges::any_of(asked, [&](const json& object) { return object["id"] == washer->id; }));
  const json truth =
      evaluated({map, "--truth", day, "--classes",
                 std::filesystem::path(ESTANCIA_SOURCE_DIR) / "lab/experiments/home/classes/things.toml"});
  EXPECT_EQ(truth["frames_with_seen_room"], 320);
  EXPECT_GT(truth["seen_purity"], truth["purity"]) << "words tell what is seen, not where the robot stands";
  EXPECT_GE(truth["area_v_measure"], 0.9);
  EXPECT_NEAR(truth["trajectory_rmse"], 0, 1e-6) << "true poses were given";
  EXPECT_GE(truth["things"], 60);
  EXPECT_GE(truth["object_recall"], 0.5);
  EXPECT_GE(truth["object_precision"], 0.4);
  EXPECT_LE(truth["object_error"], 0.1);
  EXPECT_LE(truth["merged_objects"], 20);
  EXPECT_GE(truth["nameable_things"], 15);
}

/// One test, since labeling takes longer than all else: labels are kept from one command to the next.
TEST(Home, IsMappedByDayFoundAgainInTheEveningAndOneMapOfBoth) {
  const auto data = findData("home_a");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(data && model, "the rendered home or the default network are not here");
  const ScratchFolder scratch;
  setenv("ESTANCIA_CACHE", (scratch / "cache").c_str(), 1);
  const std::string map = scratch / "home.estancia";
  ASSERT_EQ(run({"map", *data / "day", "-o", map}).exitCode, 0);
  expectRoomsAndThings(map, *data / "day");
  // 91 of the evening's frames were taken within 0.7 m and 30° of one of the day; the path is another one.
  const json filtered = evaluated({map, *data / "evening"});
  EXPECT_GE(filtered["recall"], 0.90);
  EXPECT_GE(filtered["belief_recall"], 0.92);
  EXPECT_LT(filtered["belief_median_error"], filtered["median_error"]);

  const std::string evening = scratch / "evening.estancia", merged = scratch / "merged.estancia";
  ASSERT_EQ(run({"map", *data / "evening", "-o", evening}).exitCode, 0);
  ASSERT_EQ(run({"merge", map, evening, "-o", merged}).exitCode, 0);
  expectOneHome(merged);
  expectJoinedPlacesInOneRoom(readMap(merged), 5);
  const auto mapped = run({"map", *data / "evening", "-o", map, "--continue"});
  ASSERT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_LT(expectOneHome(map)["recognized"]["after"], 10);
  EXPECT_GE(json::parse(run({"changes", map, "--json"}).out)["objects"].size(), 10U)
      << "18 were moved, gone or new, and two moved with these";
  unsetenv("ESTANCIA_CACHE");
}

TEST(Kitchen, OfRedKitchenIsMappedAtItsTruePositions) {
  const auto data = findData("sevenscenes_redkitchen"), models = findTestModels();
  ESTANCIA_NEEDS(data && models, "the kitchen sequence or the test networks are not here");
  const ScratchFolder scratch;
  writeFile(scratch / "model/net.onnx", readFile(*models / "mobilenet_v1_0.5_160_quant.onnx"));
  writeFile(scratch / "model/labels.txt", readFile(*models / "imagenet_1001.txt"));
  writeFile(
      scratch / "model/model.toml",
      "name = \"mobilenet\"\nfile = \"net.onnx\"\nlabels = \"labels.txt\"\ninput = 160\nregion = \"square\"\n"
      "crop = 0.875\ncolor = \"RGB\"\nmean = 127.5\nscale = 0.00784313725490196\n");
  const std::string map = scratch / "kitchen.estancia";
  EXPECT_EQ(jsonOf(run({"map", *data, "-o", map, "--model", scratch / "model", "--layers", "places",
                        "--json"}))["frames"],
            200);
  const json quality = evaluated({map});
  EXPECT_GT(quality["nodes"], 3);
  EXPECT_LT(quality["spatial_spread"], 0.6) << "a place is a part of the room";
  EXPECT_EQ(run({"export", map, "--format", "nav2", "-o", scratch / "kitchen.geojson"}).exitCode, 0);
}

/// Maps a drive, and goes on with the map where there is one.
void mapInto(const std::string& file, const DescriptorSequence& drive) {
  auto session = std::filesystem::exists(file)
                     ? MappingSession::resume(file, drive.vocabulary, drive.model)
                     : MappingSession::create(file, drive.vocabulary, drive.model, {});
  session.beginDrive({drive.frames.front().name});
  for (std::size_t i = 0; i < drive.frames.size(); ++i)
    session.add(drive.frames[i], drive.descriptors.row(i));
  session.finish();
}

/// The places of the last `images` images, numbered as they come.
std::vector<int> lastPlaces(const std::string& file, std::size_t images) {
  const TopologicalMap map = readMap(file);
  std::map<int, int> numbers;
  std::vector<int> places;
  for (std::size_t i = map.frames.size() - images; i < map.frames.size(); ++i)
    places.push_back(numbers.emplace(map.frames[i].node, static_cast<int>(numbers.size())).first->second);
  return places;
}

TEST(FurnishedHome, AndAnotherBuildingHaveThePlacesThatEachHasAlone) {
  const auto home = findData("home_a"), other = findData("corridor_vpr");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(home && other && model,
                 "the rendered home, the corridor or the default network are not here");
  const ScratchFolder scratch;
  std::vector<DescriptorSequence> drives;
  std::vector<std::vector<int>> alone;
  for (const auto& folder : {*home / "evening", *other / "ref"}) {
    const std::string name = std::to_string(drives.size()), file = scratch / (name + ".labels");
    ASSERT_EQ(run({"label", folder, "-o", file}).exitCode, 0);
    drives.push_back(readDescriptors(file));
    mapInto(scratch / name, drives.back());
    alone.push_back(lastPlaces(scratch / name, drives.back().frames.size()));
  }
  EXPECT_GE(std::set(alone[0].begin(), alone[0].end()).size(), 10U);
  EXPECT_GE(std::set(alone[1].begin(), alone[1].end()).size(), 8U);
  for (const std::size_t second : {0U, 1U}) {
    const std::string file = scratch / std::to_string(1 - second);
    const std::size_t before = readMap(file).nodes.size();
    mapInto(file, drives[second]);
    EXPECT_EQ(lastPlaces(file, drives[second].frames.size()), alone[second]) << second;
    EXPECT_EQ(readMap(file).nodes.size(),
              before + std::set(alone[second].begin(), alone[second].end()).size())
        << "those before are as they were";
    EXPECT_FALSE(readMap(file).drives[1].alignment);
  }
}

}  // namespace
}  // namespace estancia::test
