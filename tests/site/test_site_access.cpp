// Who may ask the server: its names, origins, tokens, and types.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/site_access.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace estancia {
namespace {

using Headers = std::initializer_list<std::pair<const std::string, std::string>>;

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
