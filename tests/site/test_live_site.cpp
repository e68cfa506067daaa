// The API against its own description, and what it refuses, without a socket.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/live_site.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/site/site_assets.hpp"
#include "fake_view.hpp"
#include "schema_check.hpp"

namespace estancia {
namespace {

using test::FakeView;
using test::schemaProblem;
using Json = nlohmann::json;
using Query = std::multimap<std::string, std::string>;

class Site : public testing::Test {
 protected:
  Site() { site_.open({"", 8765, ""}); }
  ServerResponse ask(const ServerRequest& asked) {
    ServerRequest request = asked;
    request.headers.emplace("host", "localhost:8765");
    if (asked.method == "POST") request.headers.emplace("content-type", "application/json");
    auto refused = site_.refusal(request);
    return refused ? *refused : site_.answer(request);
  }
  ServerResponse get(const std::string& path, const Query& query = {}) { return ask({"GET", path, query}); }
  int statusOf(const std::string& path, const Query& query = {}) { return get(path, query).status; }

  /// Expects that the answer matches openapi.json for this path.
  void expectDescribed(const ServerResponse& response, const std::string& path,
                       const std::string& method = "get") {
    ASSERT_TRUE(description_["paths"][path].contains(method)) << path;
    const Json responses = description_["paths"][path][method]["responses"];
    const std::string status = std::to_string(response.status);
    const Json& described = responses[responses.contains(status) ? status : "default"];
    ASSERT_TRUE(described["content"].contains(response.type)) << path << " gives " << response.type;
    if (response.type != "application/json") return;
    EXPECT_EQ(schemaProblem(Json::parse(response.body), described["content"][response.type]["schema"],
                            description_),
              "")
        << path;
  }

  FakeView view_;
  LiveSite site_{view_};
  const Json description_ = Json::parse(openApi);
};

TEST_F(Site, EveryPathThatIsServedIsDescribedAndNoOther) {
  std::vector<std::string> described;
  for (const auto& [path, operations] : description_["paths"].items())
    for (const auto& [method, operation] : operations.items())
      described.push_back((method == "get" ? "GET " : method == "post" ? "POST " : "? ") + path);
  EXPECT_THAT(LiveSite::operations(), testing::UnorderedElementsAreArray(described));
}

TEST_F(Site, AnswersAreAsDescribed) {
  for (const auto& [path, of, query] : std::vector<std::tuple<std::string, std::string, Query>>{
           {"/api/status", "", {}},
           {"/api/where", "", {}},
           {"/api/ask", "", {{"words", "coffee mug"}, {"max", "3"}}},
           {"/api/ask", "", {{"words", "room"}}},
           {"/api/ask", "", {{"words", "kitchen"}}},
           {"/api/ask", "", {{"words", "cofee mugg"}}},
           {"/api/ask", "", {{"words", "xqzzkw"}}},
           {"/api/route", "", {{"to", "umbrella"}}},
           {"/api/route", "", {{"to", "kitchen"}, {"from", "3"}}},
           {"/api/route", "", {{"to", "2"}, {"avoid", "1"}, {"avoid", "umbrella"}, {"prefer", "corridor"}}},
           {"/api/route", "", {{"to", "bathtub"}}},
           {"/api/objects", "", {}},
           {"/api/areas", "", {}},
           {"/api/changes", "", {}},
           {"/api/changes", "", {{"since", "1"}}},
           {"/api/map", "", {}},
           {"/api/places/3", "/api/places/{node}", {}},
           {"/api/places/2.jpg", "/api/places/{node}.jpg", {}},
           {"/api/objects/1.jpg", "/api/objects/{object}.jpg", {}},
           {"/api/frame.jpg", "", {{"revision", "7"}}},
           {"/api/events", "", {}},
           {"/api/openapi.json", "", {}}}) {
    const ServerResponse response = get(path, query);
    EXPECT_EQ(response.status, 200) << path << response.body;
    expectDescribed(response, of.empty() ? path : of);
  }
}

TEST_F(Site, FailuresAreAsDescribed) {
  for (const auto& [path, of, query, status] : std::vector<std::tuple<std::string, std::string, Query, int>>{
           {"/api/status", "", {{"x", "1"}}, 400},
           {"/api/ask", "", {}, 400},
           {"/api/ask", "", {{"words", ""}}, 400},
           {"/api/ask", "", {{"words", "a"}, {"words", "b"}}, 400},
           {"/api/ask", "", {{"words", std::string(1001, 'a')}}, 400},
           {"/api/ask", "", {{"words", "a"}, {"max", "0"}}, 400},
           {"/api/ask", "", {{"words", "a"}, {"max", "1e3"}}, 400},
           {"/api/ask", "", {{"words", "a"}, {"max", "99999999999999999999"}}, 400},
           {"/api/route", "", {{"to", "mug"}, {"from", "-1"}}, 400},
           {"/api/route", "", {{"to", "77"}}, 404},
           {"/api/route", "", {{"to", "2"}, {"avoid", "xqzzkw"}}, 404},
           {"/api/route", "", {{"to", "xqzzkw"}}, 404},
           {"/api/changes", "", {{"since", "0"}}, 400},
           {"/api/changes", "", {{"since", "9"}}, 404},
           {"/api/places/77", "/api/places/{node}", {}, 404},
           {"/api/places/77.jpg", "/api/places/{node}.jpg", {{"x", "1"}}, 400}}) {
    const ServerResponse response = get(path, query);
    EXPECT_EQ(response.status, status) << path << response.body;
    expectDescribed(response, of.empty() ? path : of);
  }
  view_.change([](LiveStatus& status, auto& world) {
    status = {};
    world = nullptr;
  });
  for (const char* path : {"/api/map", "/api/objects", "/api/areas", "/api/changes"}) {
    EXPECT_EQ(statusOf(path), 409) << path;
    expectDescribed(get(path), path);
  }
  expectDescribed(get("/api/status"), "/api/status");
  EXPECT_EQ(statusOf("/api/status"), 200) << "before the first image, too";
}

TEST_F(Site, EditsAreAsDescribed) {
  for (const char* edit : {R"({"type": "name_area", "area": 1, "name": "spa"})",
                           R"({"type": "merge_areas", "area": 1, "other": 2})",
                           R"({"type": "split_area", "from": [1, 2.5], "to": [3, 4]})",
                           R"({"type": "name_object", "object": 1, "name": "cup"})",
                           R"({"type": "delete_object", "object": 3})"}) {
    const Json schema =
        description_["paths"]["/api/edits"]["post"]["requestBody"]["content"]["application/json"]["schema"];
    EXPECT_EQ(schemaProblem(Json::parse(edit), schema, description_), "");
    const ServerResponse response = ask({"POST", "/api/edits", {}, {}, edit});
    EXPECT_EQ(response.status, 200) << response.body;
    expectDescribed(response, "/api/edits", "post");
  }
  EXPECT_EQ(view_.edits().size(), 5U);
  for (const auto& [edit, status] : std::vector<std::pair<std::string, int>>{
           {"", 400}, {"[", 400}, {R"({"type": "name_area", "area": 77, "name": "spa"})", 404}}) {
    const ServerResponse response = ask({"POST", "/api/edits", {}, {}, edit});
    EXPECT_EQ(response.status, status) << edit;
    expectDescribed(response, "/api/edits", "post");
  }
}

TEST_F(Site, EditsOfAMapThatHasChangedSinceAreNotDone) {
  const std::string now = std::to_string(view_.status().mapRevision);
  const auto name = [&](const std::string& revision) {
    const ServerResponse response = ask({"POST",
                                         "/api/edits",
                                         {{"map_revision", revision}},
                                         {},
                                         R"({"type": "name_area", "area": 1, "name": "spa"})"});
    expectDescribed(response, "/api/edits", "post");
    return response.status;
  };
  EXPECT_EQ(name(std::to_string(view_.status().mapRevision + 1)), 409);
  EXPECT_EQ(name("soon"), 400);
  EXPECT_TRUE(view_.edits().empty());
  EXPECT_EQ(name(now), 200);
  EXPECT_EQ(name(now), 409) << "it has changed by the edit";
}

TEST_F(Site, NothingElseIsServed) {
  for (const char* path : {"", "//", "/../page.js", "/..%2fetc/passwd", "/api", "/api/places/x",
                           "/api/places/-1", "/api/places/99999999999", "/API/where", "/site_assets.hpp"}) {
    EXPECT_EQ(statusOf(path), 404) << path;
    EXPECT_TRUE(Json::accept(get(path).body));
  }
  EXPECT_EQ(ask({"POST", "/api/where"}).status, 405);
  EXPECT_EQ(get("/api/edits").status, 405);
  for (const char* method : {"PUT", "DELETE", "OPTIONS", ""})
    EXPECT_EQ(ask({method, "/api/where"}).status, 405) << method;
  EXPECT_TRUE(view_.edits().empty());
}

TEST_F(Site, EveryAnswerIsSafe) {
  const std::vector<ServerResponse> answers{
      get("/"),           get("/page.js"),
      get("/page.css"),   get("/api/status"),
      get("/api/events"), get("/nothing"),
      ask({"PUT", "/"}),  site_.refusal({"GET", "/", {}, {{"host", "evil.example"}}}).value()};
  for (const ServerResponse& answer : answers) {
    const auto header = [&](const std::string& name) {
      for (const auto& [key, value] : answer.headers)
        if (key == name) return value;
      return std::string();
    };
    EXPECT_NE(header("Content-Security-Policy").find("frame-ancestors 'none'"), std::string::npos);
    EXPECT_EQ(header("Content-Security-Policy").find("unsafe"), std::string::npos);
    EXPECT_EQ(header("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(header("Cache-Control"), "no-store");
    EXPECT_EQ(header("Access-Control-Allow-Origin"), "");
  }
}

TEST(SiteBeforeItIsOpen, LetsNobodyIn) {
  FakeView view;
  LiveSite site(view);
  EXPECT_EQ(site.refusal({"GET", "/", {}, {{"host", "localhost:8765"}}}).value().status, 503);
}

}  // namespace
}  // namespace estancia
