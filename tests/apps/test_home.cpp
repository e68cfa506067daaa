// A furnished home (home_a): the robot knows where it is back, and zones of its map are rooms.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "experiments/src/places/revisits.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using experiments::Revisits;

/// Maps a drive into `file`.
Revisits revisitsOf(const DescriptorSequence& drive, bool withPoses, const std::string& file) {
  auto session = MappingSession::create(file, drive.vocabulary, drive.model, {}, ExistingMap::replace);
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    Frame frame = drive.frames[i];
    if (!withPoses) frame.pose.reset();
    session.add(frame, drive.descriptors.row(i));
  }
  session.finish();
  return experiments::revisitsIn(drive.frames, session.map());
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

double agreementOfZones(const std::string& map, const std::string& zones) {
  EXPECT_EQ(run({"zones", "find", map, "-o", zones, "--overwrite"}).exitCode, 0);
  return nlohmann::json::parse(run({"evaluate", zones, "--json"}).out)["v_measure"];
}

TEST(FurnishedHome, IsKnownAgain) {
  const auto data = findData("home_a");
  const auto model = findFetched("models/inception-v3/inception-v3.onnx");
  ESTANCIA_NEEDS(data && model, "the rendered home or the default network are not here");
  const ScratchFolder scratch;
  const std::string map = scratch / "home.estancia", zones = scratch / "home.zones";
  double frames = 0, byPoses = 0, byWords = 0;
  for (const std::string drive : {"day", "evening", "slow"}) {
    const std::string file = scratch / (drive + ".labels");
    ASSERT_EQ(run({"label", *data / drive, "-o", file}).exitCode, 0);
    const DescriptorSequence words = readDescriptors(file);
    const Revisits alone = revisitsOf(words, false, map);
    if (drive == "day") {
      EXPECT_GE(agreementOfZones(map, zones), 0.62);
    }
    const Revisits posed = revisitsOf(words, true, map);
    if (drive == "day") {
      EXPECT_GE(agreementOfZones(map, zones), 0.75);
    }
    EXPECT_EQ(alone.wrong, 0U) << drive;
    EXPECT_EQ(posed.wrong, 0U) << drive;
    EXPECT_GT(alone.decisions, 0U) << drive;
    EXPECT_GT(posed.decisions, 0U) << drive;
    frames += static_cast<double>(posed.frames);
    byPoses += static_cast<double>(posed.found);
    byWords += static_cast<double>(alone.found);
    if (drive == "slow") {  // a loop of 16 m
      EXPECT_EQ(posed.firstFound, posed.first);
      ASSERT_TRUE(alone.first && alone.firstFound);
      EXPECT_LE(*alone.firstFound, *alone.first + 2) << "12 cm later";
    }
  }
  EXPECT_GE(byPoses / frames, 0.9);
  EXPECT_GE(byWords / frames, 0.75);
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
