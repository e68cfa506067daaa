// What is asked of a live view, by the page and by agents; corrections as people send them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/live/edits.hpp"
#include "estancia/site/mcp.hpp"
#include "estancia/site/queries.hpp"
#include "site/fake_view.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;
using test::FailsWith;
using test::FakeView;

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

/// The places of the sample world without poses, areas or objects.
WorldMap onlyPlaces() {
  TopologicalMap places = test::samplePlaces();
  for (MappedFrame& frame : places.frames) frame.pose.reset();
  const std::vector<int> none(places.frames.size(), -1);
  return {.places = places, .zoneOfFrame = none, .areaOfFrame = none};
}

TEST(LiveQueries, WhereTellsWhatIsKnownOfRoomsAndOfPlacesThatTheMapDoesNotHaveYet) {
  FakeView view;
  const LiveQueries queries(view);
  view.change([](LiveStatus& status, auto& world) {
    WorldMap named = *world;
    named.areas[0].predictedRoom = "galley";
    named.places.frames[3].room = "store";
    world = std::make_shared<const WorldMap>(std::move(named));
    status.pose->x = std::nan("");
  });
  EXPECT_EQ(queries.where()["room"], "galley");
  EXPECT_TRUE(queries.where()["pose"].is_null());
  const auto at = [&](int node, std::optional<double> unmapped) {
    view.change([&](LiveStatus& status, auto&) {
      status.area = -1;
      status.places = {{node, 0.8}};
      status.unmapped = unmapped;
    });
    return queries.where();
  };
  EXPECT_EQ(at(1, {})["place"]["name"], "store") << "its room goes before the words of its area";
  EXPECT_EQ(at(1, 0.1)["sentence"], "At place 1 (80 %)");
  EXPECT_NE(at(1, 0.9)["sentence"].get<std::string>().find("90 %"), std::string::npos);
  EXPECT_TRUE(at(99, {})["place"]["name"].is_null());
  view.change([](LiveStatus&, auto& world) { world = nullptr; });
  EXPECT_TRUE(queries.where()["place"]["name"].is_null());
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
        std::string(R"({"type": "name_area"})"), std::string(R"({"type": 7})"), std::string(R"({"area": 7})"),
        std::string(R"({"type": "name_area", "area": 0, "name": 7})"),
        std::string(R"({"type": "name_area", "area": 0.5, "name": "a"})"),
        std::string(R"({"type": "name_area", "area": -1, "name": "a"})"),
        std::string(R"({"type": "delete_object", "object": 2147483648})"),
        std::string(R"({"type": "delete_object", "object": 1, "name": "a"})"),
        std::string(R"({"type": "split_area", "from": 7, "to": [3, 4]})"),
        std::string(R"({"type": "split_area", "from": [1, 2], "to": [3, "4"]})"),
        std::string(R"({"type": "name_area", "area": 0, "name": "a\nb"})"),
        R"({"type": "name_area", "area": 0, "name": ")" + longName + "\"}",
        std::string(R"({"type": "split_area", "from": [1], "to": [3, 4]})")})
    EXPECT_THAT([&] { parseEdit(text); }, FailsWith(ErrorCode::invalidInput)) << text;
}

TEST(LiveQueries, PlacesWithoutPosesAreDrawnByTheirTransitions) {
  FakeView view;
  view.change([](LiveStatus&, auto& world) { world = std::make_shared<const WorldMap>(onlyPlaces()); });
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

class Mcp : public testing::Test {
 protected:
  Json ask(const Json& message) { return Json::parse(server_.answer(message.dump())); }
  Json request(const std::string& method, const Json& params = Json::object()) {
    return ask({{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}});
  }
  Json call(const std::string& tool, const Json& arguments = Json::object()) {
    return request("tools/call", {{"name", tool}, {"arguments", arguments}});
  }
  static std::string textIn(const Json& answer) { return answer["result"]["content"][0]["text"]; }
  void expectFact(const std::string& tool, const Json& arguments, const std::string& fact) {
    EXPECT_THAT(textIn(call(tool, arguments)), testing::HasSubstr(fact));
  }

  FakeView view_;
  McpServer server_{view_};
};

TEST_F(Mcp, NegotiatesTheVersion) {
  const auto versionFor = [&](const std::string& wanted) {
    return request("initialize",
                   {{"protocolVersion", wanted},
                    {"capabilities", Json::object()},
                    {"clientInfo", {{"name", "test"}, {"version", "1"}}}})["result"]["protocolVersion"];
  };
  EXPECT_EQ(versionFor("2025-06-18"), "2025-06-18");
  EXPECT_TRUE(call("where_am_i")["result"].contains("structuredContent"));
  EXPECT_EQ(versionFor("1999-01-01"), "2025-06-18");
  EXPECT_EQ(versionFor("2024-11-05"), "2024-11-05");
  EXPECT_FALSE(call("where_am_i")["result"].contains("structuredContent")) << "that version does not have it";
  EXPECT_EQ(request("initialize")["error"]["code"], -32602);
}

TEST_F(Mcp, NotificationsAndAnswersAreNotAnswered) {
  EXPECT_EQ(server_.answer(R"({"jsonrpc": "2.0", "method": "notifications/initialized"})"), "");
  EXPECT_EQ(server_.answer(R"({"jsonrpc": "2.0", "method": "no such notification", "params": 7})"), "");
  EXPECT_EQ(server_.answer(R"({"jsonrpc": "2.0", "id": 4, "result": {}})"), "");
  EXPECT_EQ(request("ping")["result"], Json::object());
  EXPECT_EQ(ask({{"jsonrpc", "2.0"}, {"id", "a"}, {"method", "ping"}})["id"], "a");
}

TEST_F(Mcp, ListsToolsWithSchemas) {
  const Json tools = request("tools/list")["result"]["tools"];
  std::vector<std::string> names;
  for (const Json& tool : tools) {
    names.push_back(tool["name"]);
    EXPECT_EQ(tool["inputSchema"]["type"], "object");
    EXPECT_TRUE(tool["inputSchema"]["properties"].is_object()) << tool;
    EXPECT_FALSE(tool["description"].get<std::string>().empty());
  }
  EXPECT_THAT(names, testing::ElementsAre("find", "where_am_i", "route_to", "describe_place", "list_areas",
                                          "list_changes"));
}

TEST_F(Mcp, ToolsAnswer) {
  const Json found = call("find", {{"words", "coffee mug"}, {"max", 2.0}})["result"];
  EXPECT_EQ(found["structuredContent"]["objects"][0]["id"], 1);
  EXPECT_EQ(found["isError"], false);
  EXPECT_EQ(
      call("route_to", {{"to", "umbrella"}, {"avoid", {"1"}}})["result"]["structuredContent"]["object"]["id"],
      3);
  /// The one test of the wording: an agent reads sentences.
  for (const auto& [tool, arguments, fact] : std::vector<std::tuple<std::string, Json, std::string>>{
           {"find", {{"words", "coffee mug"}}, "object 1: coffee mug"},
           {"find", {{"words", "umbrela"}}, "umbrella"},
           {"find", {{"words", "qqqqqqqq"}}, "Nothing on the map means that."},
           {"where_am_i", Json::object(), "kitchen"},
           {"find", {{"words", "kitchen"}}, "area 0: kitchen, 32.0 m²"},
           {"route_to", {{"to", "2"}, {"from", 3}}, "From place 3 to place 2"},
           {"route_to", {{"to", "2"}, {"avoid", {"corridor"}}}, "It crosses corridor"},
           {"describe_place", {{"place", 3}}, "umbrella 50 %"},
           {"list_areas", Json::object(), "area 0: kitchen"},
           {"list_changes", Json::object(), "moved: coffee mug, from (1.00"},
           {"list_changes", Json::object(), "place 2 looks different"}})
    expectFact(tool, arguments, fact);
  view_.change([](LiveStatus&, auto& world) { world = std::make_shared<const WorldMap>(onlyPlaces()); });
  for (const auto& [tool, arguments, fact] : std::vector<std::tuple<std::string, Json, std::string>>{
           {"find", {{"words", "umbrella"}}, "place 3 holds it with 50.0 %"},
           {"route_to", {{"to", "2"}, {"from", 3}}, "over the places 3, 2."},
           {"describe_place", {{"place", 3}}, "Place 3. Seen there: umbrella 50 %"},
           {"list_areas", Json::object(), "no areas"}})
    expectFact(tool, arguments, fact);
}

TEST_F(Mcp, WhatAToolCannotDoIsAnAnswer) {
  for (const auto& [tool, arguments] :
       std::vector<std::pair<std::string, Json>>{{"find", Json::object()},
                                                 {"find", {{"words", 7}}},
                                                 {"find", {{"words", ""}}},
                                                 {"find", {{"words", "mug"}, {"max", 0}}},
                                                 {"find", {{"words", "mug"}, {"max", 1.5}}},
                                                 {"find", {{"words", "mug"}, {"maximum", 3}}},
                                                 {"where_am_i", {{"x", 1}}},
                                                 {"route_to", {{"to", "mug"}, {"from", -1}}},
                                                 {"route_to", {{"to", "mug"}, {"avoid", "kitchen"}}},
                                                 {"route_to", {{"to", "mug"}, {"avoid", {1}}}},
                                                 {"route_to", {{"to", "77"}}},
                                                 {"describe_place", {{"place", 77}}},
                                                 {"describe_place", {{"place", 1e300}}},
                                                 {"describe_place", {{"place", "3"}}}}) {
    const Json answer = call(tool, arguments);
    EXPECT_EQ(answer["result"]["isError"], true) << tool << arguments;
    EXPECT_FALSE(textIn(answer).empty());
  }
  EXPECT_EQ(call("find", {{"words", "xyzzy plugh"}})["result"]["isError"], false)
      << "nothing found is no error";
  view_.change([](LiveStatus& status, auto& world) {
    status = {};
    world = nullptr;
  });
  EXPECT_EQ(call("list_areas")["result"]["isError"], true);
  EXPECT_EQ(call("where_am_i")["result"]["isError"], false);
}

TEST_F(Mcp, WhatIsNoRequestIsAnErrorOfTheProtocol) {
  const auto codeOf = [&](const std::string& line) {
    return Json::parse(server_.answer(line))["error"]["code"];
  };
  for (const char* line :
       {"garbage", "{", "\xFF\xFE", "{\"jsonrpc\": \"2.0\", \"id\": 1, \"method\": \"\xC3\"}"})
    EXPECT_EQ(codeOf(line), -32700) << line;
  EXPECT_EQ(codeOf(std::string(100000, '[')), -32700);
  EXPECT_EQ(codeOf(std::string(50000, '[') + std::string(50000, ']')), -32600);
  for (const char* line :
       {"[]", "7", "null", R"([{"jsonrpc": "2.0", "id": 1, "method": "ping"}])",
        R"({"id": 1, "method": "ping"})", R"({"jsonrpc": "1.0", "id": 1, "method": "ping"})",
        R"({"jsonrpc": "2.0", "id": 1})", R"({"jsonrpc": "2.0", "id": 1, "method": 7})",
        R"({"jsonrpc": "2.0", "id": null, "method": "ping"})",
        R"({"jsonrpc": "2.0", "id": {"a": [1]}, "method": "ping"})",
        R"({"jsonrpc": 2, "id": 1, "method": "ping"})"})
    EXPECT_EQ(codeOf(line), -32600) << line;
  EXPECT_EQ(request("resources/list")["error"]["code"], -32601);
  EXPECT_EQ(request("tools/call", {{"name", "no_such_tool"}})["error"]["code"], -32602);
  EXPECT_EQ(request("tools/call", {{"name", 7}})["error"]["code"], -32602);
  EXPECT_EQ(request("tools/call", {{"name", "find"}, {"arguments", 7}})["error"]["code"], -32602);
  for (const Json& params : {Json::array(), Json::object()})
    EXPECT_EQ(request("tools/call", params)["error"]["code"], -32602);
  EXPECT_EQ(request("initialize", {{"protocolVersion", 7}})["error"]["code"], -32602);
  EXPECT_FALSE(request("tools/call", {{"name", "list_areas"}, {"arguments", nullptr}}).contains("error"));
}

TEST(McpCommand, AnswersOnStandardOutput) {
  const test::ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  const test::CommandResult result = test::runProgram(
      "/bin/sh", {"-c", R"(echo '{"jsonrpc": "2.0", "id": 1, "method": "tools/list"}' | "$0" mcp "$1")",
                  ESTANCIA_COMMAND, file.string()});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(Json::parse(result.out)["result"]["tools"].size(), 6U);
}

TEST_F(Mcp, LinesOfAnyLengthComeThroughPipes) {
  std::array<int, 2> in{}, out{};
  ASSERT_EQ(pipe(in.data()), 0);
  ASSERT_EQ(pipe(out.data()), 0);
  std::thread serving([&] {
    serveMcp(server_, in[0], out[1], [] { return false; });
    close(out[1]);
  });
  std::thread reading;
  std::string answers;
  reading = std::thread([&] {
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = read(out[0], part.data(), part.size())) > 0;)
      answers.append(part.data(), static_cast<std::size_t>(got));
  });
  const std::string huge =
      "{\"jsonrpc\": \"2.0\", \"id\": 1, \"x\": \"" + std::string(3 << 20, 'x') + "\"}\n";
  const std::string lines = huge + "\n\r\n{\"jsonrpc\": \"2.0\", \"id\": 2, \"method\": \"ping\"}\r\n" +
                            "{\"jsonrpc\": \"2.0\", \"id\": 3, \"method\": \"ping\"}";  // cut off
  for (std::size_t at = 0; at < lines.size();) {
    const ssize_t written = write(in[1], lines.data() + at, lines.size() - at);
    ASSERT_GT(written, 0);
    at += static_cast<std::size_t>(written);
  }
  close(in[1]);
  serving.join();
  reading.join();
  close(in[0]), close(out[0]);
  std::vector<Json> parsed;
  for (std::size_t at = 0, end = 0; (end = answers.find('\n', at)) != std::string::npos; at = end + 1)
    parsed.push_back(Json::parse(answers.substr(at, end - at)));
  ASSERT_EQ(parsed.size(), 2U);
  EXPECT_EQ(parsed[0]["error"]["code"], -32600);
  EXPECT_EQ(parsed[1]["id"], 2);
}

}  // namespace
}  // namespace estancia
