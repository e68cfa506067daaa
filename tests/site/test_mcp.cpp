// Agents' questions by the Model Context Protocol: a conversation, and what is no message.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/mcp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fake_view.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FakeView;
using Json = nlohmann::json;

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
           {"route_to", {{"to", "2"}, {"from", 3}}, "From place 3 to place 2"},
           {"describe_place", {{"place", 3}}, "umbrella 50 %"},
           {"list_areas", Json::object(), "area 0: kitchen"},
           {"list_changes", Json::object(), "moved: coffee mug, from (1.00"},
           {"list_changes", Json::object(), "place 2 looks different"}})
    EXPECT_THAT(textIn(call(tool, arguments)), testing::HasSubstr(fact));
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
  EXPECT_EQ(request("tools/call", Json::array())["error"]["code"], -32602);
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
