// A furnished home (home_a) and another building in one map.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

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
