// Maps and zones name their rooms by themselves, from what their labels have to do with the rooms' names.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estancia/map_file/map.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;

const std::vector<std::string> kitchen{"stove", "microwave", "refrigerator", "toaster"},
    bathroom{"toilet seat", "bathtub", "washbasin", "shower curtain"},
    desert{"zebra", "dune", "camel", "sky"};

class RoomsByName : public testing::Test {
 protected:
  /// A recording of twenty images of each, in which the things of a room turn up one after the other.
  std::string drive(const std::string& name, const std::vector<std::vector<std::string>>& rooms) const {
    std::vector<std::string> labels;
    for (const auto* room : {&kitchen, &bathroom, &desert})
      labels.insert(labels.end(), room->begin(), room->end());
    DescriptorSequence recording{Vocabulary(labels), "test 1", {}, DescriptorMatrix(labels.size())};
    for (const std::vector<std::string>& things : rooms)
      for (std::size_t i = 0; i < 20; ++i) {
        recording.frames.emplace_back().name = "frame " + std::to_string(recording.frames.size());
        std::vector<float> image(labels.size(), 0.005F);
        for (const auto& [step, p] : {std::pair{0, 0.5F}, {1, 0.3F}, {2, 0.1F}}) {
          const std::string& thing = things[(i / 2 + static_cast<std::size_t>(step)) % things.size()];
          image[static_cast<std::size_t>(std::ranges::find(labels, thing) - labels.begin())] = p;
        }
        recording.descriptors.append(image);
      }
    const std::string file = scratch_ / name;
    writeDescriptors(recording, file);
    return file;
  }

  CommandResult map(const std::string& drive, const std::vector<std::string>& more = {"--overwrite"}) const {
    std::vector<std::string> arguments{"map", drive, "-o", map_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    CommandResult result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return result;
  }

  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "home.estancia";
};

TEST_F(RoomsByName, AreInEveryNewMap) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  const auto said = map(home);
  EXPECT_NE(said.out.find("bathroom"), std::string::npos);
  const RoomPredictions made = *readMap(map_).predictions;
  EXPECT_TRUE(made.areByName);
  EXPECT_FALSE(made.areListed);
  EXPECT_EQ(json::parse(run({"ask", map_, "kitchen", "--json"}).out)["places"][0]["predicted_room"],
            "kitchen");

  ASSERT_EQ(run({"classify", "name", map_}).exitCode, 0);
  const RoomPredictions named = *readMap(map_).predictions;
  EXPECT_EQ(made.probabilities.values(), named.probabilities.values());
  EXPECT_EQ(made.evidence.size(), named.evidence.size());

  const json summary = json::parse(map(home, {"--overwrite", "--json"}).out);
  EXPECT_GE(summary["predicted_rooms"]["kitchen"], 1);
}

TEST_F(RoomsByName, AreLeftOutForRawWordsAndWithoutWordNet) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(home, {"--words", "raw"});
  EXPECT_FALSE(readMap(map_).predictions);
  const WithoutWordNet none;
  map(home);
  EXPECT_FALSE(readMap(map_).predictions);
  EXPECT_THAT(run({"map", home, "-o", map_, "--overwrite", "--rooms-by-name", "kitchen,bathroom"}),
              FailsWith(ErrorCode::missingDependency));
}

TEST_F(RoomsByName, MayBeListedAndStaySo) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(drive("begun.labels", {kitchen}), {"--rooms-by-name", "kitchen, bathroom,Kitchens"});
  map(home, {"--continue"});
  const RoomPredictions listed = *readMap(map_).predictions;
  EXPECT_TRUE(listed.areListed);
  EXPECT_THAT(listed.rooms, ElementsAre("kitchen", "bathroom"));
  EXPECT_EQ(listed.probabilities.size(), 40U);
  ASSERT_EQ(run({"classify", "name", map_, "--rooms", "kitchen,bathroom"}).exitCode, 0);
  EXPECT_EQ(readMap(map_).predictions->probabilities.values(), listed.probabilities.values());

  const std::string other = scratch_ / "other.estancia";
  EXPECT_THAT(run({"map", home, "-o", other, "--rooms-by-name", "kitchen,xyzzy"}),
              FailsWith(ErrorCode::unknownName));
  EXPECT_FALSE(std::filesystem::exists(other)) << "before the long work begins";
}

TEST_F(RoomsByName, NeverReplaceThoseOfAClassifier) {
  const std::string home = drive("home.labels", {kitchen, bathroom});
  map(drive("begun.labels", {kitchen}));
  RoomPredictions trained{"knn on test", {"galley", "bath"}, DescriptorMatrix(2)};
  for (int i = 0; i < 20; ++i) trained.probabilities.append(std::vector<float>{0.9F, 0.1F});
  writeRoomPredictions(trained, map_);
  map(home, {"--continue"});
  EXPECT_EQ(readMap(map_).predictions->classifier, "knn on test");
}

}  // namespace
}  // namespace estancia::test
