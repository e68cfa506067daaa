// What is asked of a live view, as JSON; corrections as people send them.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/queries.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/live/edits.hpp"
#include "fake_view.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::FakeView;
using OrderedJson = nlohmann::ordered_json;

TEST(LiveQueries, WhereNamesPlaceAreaRoomAndPose) {
  const FakeView view;
  const LiveQueries queries(view);
  const OrderedJson where = queries.where();
  EXPECT_EQ(where["place"], (OrderedJson{{"node", 0}, {"name", "kitchen"}, {"probability", 0.9}}));
  EXPECT_EQ(where["area"], (OrderedJson{{"id", 0}, {"name", "kitchen"}, {"probability", 0.95}}));
  EXPECT_EQ(where["pose"], (OrderedJson{{"x", 2.0}, {"y", 2.0}, {"yaw", 0.5}}));
  EXPECT_EQ(where["belief"].size(), 2U);
  EXPECT_TRUE(where["unmapped"].is_null());
  const OrderedJson status = queries.status();
  EXPECT_EQ(status["where"], where);
  EXPECT_EQ(status["words"][0]["label"], "coffee mug");
}

TEST(LiveQueries, BeforeTheFirstImageNothingIsKnown) {
  FakeView view;
  view.change([](LiveStatus& status, auto& world) {
    status = {};
    world = nullptr;
  });
  const LiveQueries queries(view);
  const OrderedJson where = queries.where();
  for (const char* key : {"place", "area", "room", "pose", "frame"}) EXPECT_TRUE(where[key].is_null()) << key;
  EXPECT_THAT([&] { queries.ask("mug", 5); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { queries.map(); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { queries.route({"mug", 0}); }, FailsWith(ErrorCode::insufficientData));
}

TEST(LiveQueries, AskAndRouteAnswerAsTheCommandDoes) {
  const FakeView view;
  const LiveQueries queries(view);
  const OrderedJson found = queries.ask("coffee mug", 5);
  EXPECT_EQ(found["objects"][0]["id"], 1);
  EXPECT_EQ(queries.ask("coffee mug", 1)["places"].size(), 1U);
  const OrderedJson nothing = queries.ask("xqzzkw", 5);
  EXPECT_TRUE(nothing["objects"].empty());

  const OrderedJson route = queries.route({"umbrella", {}});
  EXPECT_EQ(route["from"], 0) << "where the robot is";
  EXPECT_EQ(route["object"]["id"], 3);
  EXPECT_EQ(queries.route({"2", 3})["nodes"], (OrderedJson{3, 2}));
  EXPECT_THAT([&] { queries.route({"2", 99}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { queries.route({"2", 0, {"nowhere at all"}}); }, FailsWith(ErrorCode::unknownName));
}

TEST(LiveQueries, FromAPlaceThatTheMapDoesNotHaveYetAWayStartsWhereItsLastFrameIs) {
  FakeView view;
  view.change([](LiveStatus& status, auto& world) {
    status.places = {{99, 1}};
    WorldMap before = *world;
    before.places.frames.resize(5);
    world = std::make_shared<const WorldMap>(std::move(before));
  });
  const LiveQueries queries(view);
  EXPECT_EQ(queries.route({"2", {}})["from"], 3);
  EXPECT_THAT([&] { queries.route({"2", 99}); }, FailsWith(ErrorCode::unknownName)) << "who says so is told";
  view.change([](LiveStatus& status, auto&) { status.places = {{99, 0.6}, {1, 0.4}}; });
  EXPECT_EQ(queries.route({"2", {}})["from"], 1) << "the most probable one of the map";
  view.change([](LiveStatus& status, auto&) {
    status.places = {{99, 1}};
    status.unmapped = 0.1;
  });
  EXPECT_THAT(
      [&] {
        queries.route({"2", {}});
      },
      FailsWith(ErrorCode::unknownName))
      << "who localizes has not come from the map's last frame";
}

TEST(LiveQueries, TheMapIsDrawnOncePerChange) {
  FakeView view;
  const LiveQueries queries(view);
  const auto first = queries.map();
  EXPECT_EQ(queries.map(), first);
  const OrderedJson map = OrderedJson::parse(*first);
  EXPECT_EQ(map["areas"].size(), 4U);
  EXPECT_EQ(map["areas"][0]["outlines"].size(), 1U);
  EXPECT_EQ(map["places"][0]["position"].size(), 2U);
  EXPECT_EQ(map["links"].size(), 4U);
  EXPECT_EQ(map["objects"].size(), 6U);
  EXPECT_TRUE(map["metric"]);
  view.edit(NameArea{1, "spa"});
  EXPECT_EQ(OrderedJson::parse(*queries.map())["areas"][1]["given_name"], "spa");
  EXPECT_GT(OrderedJson::parse(*queries.map())["map_revision"], map["map_revision"]);
}

TEST(LiveEdits, AreReadFromJson) {
  const auto naming = std::get<NameArea>(parseEdit(R"({"type": "name_area", "area": 2, "name": "Küche"})"));
  EXPECT_EQ(naming.area, 2);
  EXPECT_EQ(naming.name, "Küche");
  EXPECT_EQ(std::get<MergeAreas>(parseEdit(R"({"type": "merge_areas", "area": 2, "other": 5})")).other, 5);
  EXPECT_EQ(std::get<SplitArea>(parseEdit(R"({"type": "split_area", "from": [1, 2], "to": [3.5, 4]})")).to.x,
            3.5);
  EXPECT_EQ(std::get<NameObject>(parseEdit(R"({"type": "name_object", "object": 1, "name": ""})")).name, "");
  EXPECT_EQ(std::get<DeleteObject>(parseEdit(R"({"type": "delete_object", "object": 3})")).object, 3);
  const std::string longName(121, 'x');
  for (const std::string& text :
       {std::string("{"), std::string("7"), std::string(R"({"type": "drop_tables"})"),
        std::string(R"({"type": "name_area"})"),
        std::string(R"({"type": "name_area", "area": 0, "name": "a\nb"})"),
        R"({"type": "name_area", "area": 0, "name": ")" + longName + "\"}",
        std::string(R"({"type": "split_area", "from": [1], "to": [3, 4]})")})
    EXPECT_THAT([&] { parseEdit(text); }, FailsWith(ErrorCode::invalidInput)) << text;
}

TEST(LiveQueries, PlacesWithoutPosesAreDrawnByTheirTransitions) {
  FakeView view;
  view.change([](LiveStatus&, auto& world) {
    TopologicalMap places = test::samplePlaces();
    for (MappedFrame& frame : places.frames) frame.pose.reset();
    const std::vector<int> none(places.frames.size(), -1);
    world = std::make_shared<const WorldMap>(
        WorldMap{.places = places, .zoneOfFrame = none, .areaOfFrame = none});
  });
  const LiveQueries queries(view);
  const OrderedJson map = OrderedJson::parse(*queries.map());
  EXPECT_FALSE(map["metric"]);
  EXPECT_EQ(map["places"][3]["position"].size(), 2U);
  EXPECT_TRUE(map["path"].empty());
}

TEST(LiveQueries, PlacesAreDescribed) {
  const FakeView view;
  const LiveQueries queries(view);
  const OrderedJson place = queries.place(3);
  EXPECT_EQ(place["name"], "Ana's \"room\"");
  EXPECT_EQ(place["words"][0]["label"], "umbrella");
  EXPECT_EQ(place["neighbors"].size(), 2U);
  EXPECT_EQ(place["position"].size(), 2U);
  EXPECT_EQ(place["objects"].size(), 3U);
  EXPECT_THAT([&] { queries.place(-1); }, FailsWith(ErrorCode::unknownName));
}

TEST(LiveQueries, WithoutTheRobotsPlaceAWayNeedsAStart) {
  FakeView view;
  view.change([](LiveStatus& status, auto&) { status.places.clear(); });
  const LiveQueries queries(view);
  EXPECT_THAT([&] { queries.route({"umbrella", {}}); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_EQ(queries.route({"umbrella", 2})["from"], 2);
}

}  // namespace
}  // namespace estancia
