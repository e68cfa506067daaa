// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/map_json.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "map_file/sample_map.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

TEST(MapJson, TellsAnswers) {
  const TopologicalMap map = test::sampleMap();
  const Json json = toJson("desk", ask(map, "desk", 2), map, placesOf(map));
  EXPECT_EQ(json["words"], "desk");
  EXPECT_EQ(json["labels"], Json({"desk"}));
  EXPECT_EQ(json["rooms"], Json::array());
  ASSERT_EQ(json["places"].size(), 2U);
  EXPECT_EQ(json["places"][0]["node"], 3);
  EXPECT_EQ(json["places"][0]["label"], "desk");
  EXPECT_EQ(json["places"][0]["rank"], 1);
  EXPECT_EQ(json["places"][0]["among_best_5"], true);
  EXPECT_EQ(json["places"][0]["room"], "office");
  EXPECT_FALSE(json["places"][0].contains("predicted_room"));
}

TEST(MapJson, TellsPredictedRooms) {
  TopologicalMap map = test::sampleMap();
  map.predictions = RoomPredictions{"knn", {"bureau", "kitchen"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    map.predictions->probabilities.append(i < 2 ? std::vector<float>{0.25F, 0.75F}
                                                : std::vector<float>{1, 0});
  const Json json = toJson("kitchen", ask(map, "kitchen"), map, placesOf(map));
  EXPECT_EQ(json["labels"], Json::array());
  EXPECT_EQ(json["rooms"], Json({"kitchen"}));
  EXPECT_EQ(json["places"][0]["node"], 0);
  EXPECT_EQ(json["places"][0]["label"], nullptr);
  EXPECT_EQ(json["places"][0]["predicted_room"], "kitchen");
  EXPECT_NEAR(json["places"][0]["room_probability"].get<double>(), 0.75, 1e-6);
}

TEST(MapJson, TellsWhereAnImageWasTaken) {
  Localization answer;
  answer.node = 3;
  answer.nearestImage = 4;
  answer.beliefNode = 1;
  answer.beliefImage = 6;
  answer.unmapped = 0.25;
  answer.confidence = 0.5;
  EXPECT_EQ(toJson("now.jpg", answer, test::sampleMap()), (Json{{"image", "now.jpg"},
                                                                {"node", 3},
                                                                {"nearest_image", "e.jpg"},
                                                                {"nearest_frame", 4},
                                                                {"distance", 0.0},
                                                                {"belief_node", 1},
                                                                {"belief_image", "g.jpg"},
                                                                {"belief_frame", 6},
                                                                {"confidence", 0.5},
                                                                {"unmapped", 0.25},
                                                                {"unvisited", nullptr}}));
}

}  // namespace
}  // namespace estancia
