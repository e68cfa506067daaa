// The API against its own description, what it refuses and whom, without a socket.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <initializer_list>

#include "estancia/site/live_site.hpp"
#include "estancia/site/site_access.hpp"
#include "estancia/site/site_assets.hpp"
#include "site/fake_view.hpp"
#include "site/schema_check.hpp"

namespace estancia {
namespace {

using Headers = std::initializer_list<std::pair<const std::string, std::string>>;
using Json = nlohmann::json;
using Query = std::multimap<std::string, std::string>;
using test::FakeView;
using test::schemaProblem;

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

ServerRequest get(Headers headers, std::multimap<std::string, std::string> query = {}) {
  return {"GET", "/api/where", std::move(query), headers};
}

ServerRequest post(Headers headers) {
  ServerRequest request{"POST", "/api/edits", {}, headers};
  request.headers.emplace("host", "localhost:8765");
  return request;
}

/// 200 where nothing refuses it.
int statusOf(const ServerRequest& request, const SiteAccess& access = {"", 8765, ""}) {
  const auto refusal = accessRefusal(request, access);
  return refusal ? refusal->status : 200;
}

TEST(SiteAccess, KnowsItsNames) {
  for (const char* host : {"localhost:8765", "127.0.0.1:8765", "[::1]:8765", "LocalHost:8765"})
    EXPECT_EQ(statusOf(get({{"host", host}})), 200) << host;
  for (const char* host : {"evil.example:8765", "localhost", "localhost:80", "localhost:87650",
                           "127.0.0.1.evil.example:8765", "evil.example", "localhost:8765.evil.example", "",
                           ":8765", "192.168.1.7:8765", "[::2]:8765", "localhost:8765 ", "localhost.:8765"})
    EXPECT_EQ(statusOf(get({{"host", host}})), 403) << host;
  EXPECT_EQ(statusOf(get({})), 403);
  EXPECT_EQ(statusOf(get({{"host", "localhost:8765"}, {"host", "evil.example"}})), 403);
  EXPECT_EQ(statusOf(get({{"host", "localhost"}}), {"", 80, ""}), 200);
  EXPECT_EQ(statusOf(get({{"host", "[::1]"}}), {"", 80, ""}), 200);
  EXPECT_EQ(statusOf(get({{"host", "localhost:81"}}), {"", 80, ""}), 403);
}

TEST(SiteAccess, KnowsTheNameItListensAt) {
  const SiteAccess named{"robot.local", 8765, "secret"};
  const auto asked = [](const SiteAccess& access, const char* host) {
    return statusOf(get({{"host", host}}, {{"token", "secret"}}), access);
  };
  EXPECT_EQ(asked(named, "robot.local:8765"), 200);
  EXPECT_EQ(asked(named, "192.168.1.7:8765"), 403);
  EXPECT_EQ(asked(named, "evil.example:8765"), 403);
  const SiteAccess everywhere{"0.0.0.0", 8765, "secret"};
  EXPECT_EQ(asked(everywhere, "192.168.1.7:8765"), 200) << "nobody can rebind an address";
  EXPECT_EQ(asked(everywhere, "[fe80::1]:8765"), 200);
  EXPECT_EQ(asked(everywhere, "evil.example:8765"), 403);
  EXPECT_EQ(asked({"::1", 8765, "secret"}, "[::1]:8765"), 200);
  EXPECT_EQ(asked({"fe80::1", 8765, "secret"}, "[fe80::1]:8765"), 200);
  EXPECT_EQ(asked({"::", 8765, "secret"}, "192.168.1.7:8765"), 200);
  std::array<char, 256> name{};
  ASSERT_EQ(gethostname(name.data(), name.size() - 1), 0);
  for (const char* ending : {":8765", ".local:8765"})
    EXPECT_EQ(asked(everywhere, (name.data() + std::string(ending)).c_str()), 200) << ending;
  for (const char* host : {"[]:8765", "[fe80::1:8765", "[::g]:8765", "fe80::1]:8765"})
    EXPECT_EQ(asked(everywhere, host), 403) << host;
}

TEST(SiteAccess, RefusesPagesOfOtherSites) {
  const auto from = [](const char* origin) {
    return statusOf(get({{"host", "localhost:8765"}, {"origin", origin}}));
  };
  EXPECT_EQ(from("http://localhost:8765"), 200);
  for (const char* origin : {"https://localhost:8765", "http://localhost:8766", "http://127.0.0.1:8765",
                             "null", "", "http://evil.example", "http://localhost:8765.evil.example"})
    EXPECT_EQ(from(origin), 403) << origin;
  const auto fetched = [](const char* site, const char* mode) {
    return statusOf(get({{"host", "localhost:8765"}, {"sec-fetch-site", site}, {"sec-fetch-mode", mode}}));
  };
  EXPECT_EQ(fetched("same-origin", "cors"), 200);
  EXPECT_EQ(fetched("none", "navigate"), 200);
  EXPECT_EQ(fetched("cross-site", "navigate"), 200) << "a link to the page";
  EXPECT_EQ(fetched("cross-site", "no-cors"), 403) << "an image in another page";
  EXPECT_EQ(fetched("same-site", "no-cors"), 403);
  for (const auto& [header, value, code] : {std::tuple{"origin", "http://localhost:8765", 403},
                                            {"sec-fetch-site", "same-origin", 403},
                                            {"sec-fetch-mode", "navigate", 403},
                                            {"cookie", "a=b", 200}}) {
    ServerRequest twice = get({{"host", "localhost:8765"}, {header, value}, {header, value}});
    if (std::string(header) == "sec-fetch-mode") twice.headers.emplace("sec-fetch-site", "cross-site");
    EXPECT_EQ(statusOf(twice), code) << header << " twice";
  }
}

TEST(SiteAccess, TakesChangesFromItsOwnPageAlone) {
  EXPECT_EQ(statusOf(post({{"content-type", "application/json"}})), 200);
  EXPECT_EQ(statusOf(post({{"content-type", "Application/JSON ; charset=utf-8"}})), 200);
  for (const char* type :
       {"text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x",
        "text/plain; application/json", "application/json-patch", ""})
    EXPECT_EQ(statusOf(post({{"content-type", type}})), 415) << type;
  EXPECT_EQ(statusOf(post({})), 415);
  EXPECT_EQ(statusOf(post({{"content-type", "application/json"}, {"content-encoding", "gzip"}})), 415);
  EXPECT_EQ(statusOf(post({{"content-type", "application/json"}, {"origin", "http://evil.example"}})), 403);
  EXPECT_EQ(statusOf(post({{"content-type", "application/json"},
                           {"sec-fetch-site", "cross-site"},
                           {"sec-fetch-mode", "navigate"}})),
            403)
      << "a form in another page";
}

TEST(SiteAccess, WantsTheToken) {
  const SiteAccess access{"127.0.0.1", 8765, "0123456789abcdef"};
  const auto with = [&](Headers more, std::multimap<std::string, std::string> query = {}) {
    ServerRequest request = get(more, std::move(query));
    request.headers.emplace("host", "localhost:8765");
    return statusOf(request, access);
  };
  EXPECT_EQ(with({}), 401);
  EXPECT_EQ(with({}, {{"token", "0123456789abcdef"}}), 200);
  EXPECT_EQ(with({{"cookie", "estancia-8765=0123456789abcdef"}}), 200);
  EXPECT_EQ(with({{"cookie", "x=y; estancia-8765=0123456789abcdef; z"}}), 200);
  EXPECT_EQ(with({{"authorization", "Bearer 0123456789abcdef"}}), 200);
  for (const char* wrong : {"", "0123456789abcde", "0123456789abcdeF", "0123456789abcdef0"}) {
    EXPECT_EQ(with({}, {{"token", wrong}}), 401);
    EXPECT_EQ(with({{"cookie", "estancia-8765=" + std::string(wrong)}}), 401);
    EXPECT_EQ(with({{"authorization", "Bearer " + std::string(wrong)}}), 401);
  }
  EXPECT_EQ(with({{"cookie", "estancia-8766=0123456789abcdef"}}), 401) << "that of another server";
  EXPECT_EQ(with({{"cookie", ";;;==; ="}}), 401);
}

TEST(SiteAccess, TokensDiffer) {
  EXPECT_EQ(makeToken().size(), 32U);
  EXPECT_NE(makeToken(), makeToken());
}

}  // namespace
}  // namespace estancia
