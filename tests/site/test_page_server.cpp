// The server on a socket: bounds, slow clients, many listeners, and what no browser sends.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/page_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <memory>
#include <vector>

#include "fake_view.hpp"
#include "support/errors.hpp"
#include "web_client.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::FakeView;
using test::fetchWeb;
using test::optionsAt;
using test::WebAnswer;
using test::WebClient;
using Json = nlohmann::json;

class OnASocket : public testing::Test {
 protected:
  std::string head(const std::string& request) const {
    return request + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port()) + "\r\n";
  }
  int port() const { return server_.port(); }
  /// Another client is served still.
  void expectAlive() const { EXPECT_EQ(fetchWeb(port(), "/api/where").status, 200); }

  FakeView view_;
  PageServer server_{view_, optionsAt()};
};

TEST_F(OnASocket, ServesPageApiAndImages) {
  const WebAnswer page = fetchWeb(port(), "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.headers.at("content-type").find("text/html"), std::string::npos);
  const WebAnswer found =
      fetchWeb(port(), "/api/ask?words=coffee%20mug&max=1", "Accept-Encoding: gzip, br\r\n");
  EXPECT_EQ(found.headers.count("content-encoding"), 0U);
  EXPECT_EQ(Json::parse(found.body)["objects"][0]["id"], 1);
  EXPECT_EQ(fetchWeb(port(), "/api/frame.jpg").body.size(), 4U);
  EXPECT_EQ(fetchWeb(port(), "/api/objects/1.jpg").headers.at("content-type"), "image/jpeg");
  EXPECT_EQ(server_.url(), "http://127.0.0.1:" + std::to_string(port()) + "/");
}

TEST_F(OnASocket, KeepsConnections) {
  WebClient client(port());
  for (int i = 0; i < 20; ++i) {
    client.send(head("GET /api/where") + "\r\n");
    ASSERT_EQ(client.read().status, 200) << i;
  }
  client.send(head("HEAD /api/where") + "\r\n");
  EXPECT_NE(client.readUntil("\r\n\r\n").find(" 200 OK"), std::string::npos) << "without a body";
  client.send(head("GET /api/where") + "Connection: close\r\n\r\n");
  EXPECT_EQ(client.read().status, 200);
  EXPECT_EQ(client.readUntil("never"), "");
}

TEST_F(OnASocket, TakesCorrections) {
  const WebAnswer answer =
      fetchWeb(port(), "/api/edits", "", R"({"type": "name_area", "area": 1, "name": "spa"})");
  EXPECT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(view_.world()->areas[1].givenName, "spa");
  EXPECT_EQ(fetchWeb(port(), "/api/edits", "", R"({"type": "nonsense"})").status, 400);
}

TEST_F(OnASocket, RefusesHugeBodiesAndHeads) {
  const std::string huge = R"({"type": "name_area", "area": 1, "name": ")" + std::string(70'000, 'x') + "\"}";
  const WebAnswer refused = fetchWeb(port(), "/api/edits", "", huge);
  EXPECT_THAT(refused.status, testing::AnyOf(0, 413));
  if (refused.status == 413) {
    EXPECT_EQ(Json::parse(refused.body)["error"]["code"], "too-large");
  }
  const std::string post = head("POST /api/edits") + "Content-Type: application/json\r\n";
  {
    WebClient client(port());
    client.send(post + "Content-Length: 99999999999999999999\r\n\r\n{}");
    client.finish();
    EXPECT_NE(client.read().status, 200);
  }
  for (const char* length : {"0x2", "1e0", "2\r\nContent-Length: 3", "2\r\nTransfer-Encoding: chunked"}) {
    WebClient client(port());
    client.send(post + "Content-Length: " + length + "\r\n\r\n{}");
    const WebAnswer answer = client.read();
    EXPECT_EQ(answer.status, 400) << length;
  }
  {  // chunks do not announce the length
    WebClient client(port());
    client.send(post + "Transfer-Encoding: chunked\r\n\r\n");
    const std::string chunk = "4000\r\n" + std::string(0x4000, ' ') + "\r\n";
    bool isOpen = true;
    for (int i = 0; i < 4000 && isOpen; ++i) isOpen = client.send(chunk);
    EXPECT_FALSE(isOpen) << "64 MB were taken";
  }
  {
    WebClient client(port());
    bool isOpen = client.send(head("GET /"));
    for (int i = 0; i < 100'000 && isOpen; ++i)
      isOpen = client.send("X-" + std::to_string(i) + ": " + std::string(500, 'x') + "\r\n");
    EXPECT_FALSE(isOpen) << "50 MB were taken";
  }
  EXPECT_TRUE(view_.edits().empty());
  expectAlive();
}

TEST_F(OnASocket, WhatIsRefusedIsNotReadAsTheNextRequest) {
  WebClient client(port());
  const std::string second = head("GET /api/where") + "\r\n";
  client.send(head("POST /api/where") + "Content-Type: application/json\r\nContent-Length: " +
              std::to_string(second.size()) + "\r\n\r\n" + second);
  const WebAnswer answer = client.read();
  EXPECT_EQ(answer.status, 405);
  EXPECT_EQ(answer.headers.at("connection"), "close");
  EXPECT_EQ(client.read().status, 0);
}

TEST_F(OnASocket, BearsWhatIsNoHttp) {
  std::string ranges;
  for (int i = 0; i < 1500; ++i) ranges += "0-,";
  for (const std::string& bytes :
       {std::string("garbage\r\n\r\n"), std::string(5000, '\0'),
        head("GET /api/where") + "Range: bytes=" + ranges + "0-\r\n\r\n", head("GET /%00%0a") + "\r\n"}) {
    WebClient client(port());
    client.send(bytes);
    client.finish();
    EXPECT_LT(client.read().body.size(), 10'000U);
    expectAlive();
  }
}

TEST_F(OnASocket, ElevenPagesListenAndOneThatDoesNotReadHindersNobody) {
  std::vector<std::unique_ptr<WebClient>> pages;
  for (int i = 0; i < 12; ++i) {
    pages.push_back(std::make_unique<WebClient>(port()));
    if (i == 0) pages.back()->receiveSlowly();
    pages.back()->send(head("GET /api/events") + "\r\n");
  }
  for (std::size_t i = 1; i < pages.size(); ++i)
    EXPECT_TRUE(pages[i]->readUntil("event: status\n").ends_with("event: status\n"));
  for (std::uint64_t revision = 8; revision < 20; ++revision) {
    // The one that does not read is full soon.
    const std::string last = std::string(20'000, 'x') + std::to_string(revision) + ".";
    view_.change([&](LiveStatus& status, auto&) { status.decision = last; });
    for (std::size_t i = 1; i < pages.size(); ++i)
      EXPECT_TRUE(pages[i]->readUntil(last).ends_with(last)) << i;
  }
  expectAlive();
}

TEST_F(OnASocket, AStreamGoesOnWhereItWas) {
  WebClient client(port());
  client.send(head("GET /api/events") + "Last-Event-ID: 7\r\n\r\n");
  client.readUntil("retry: 1000");
  view_.change([](LiveStatus& status, auto&) { status.frames = 99; });
  const std::string next = client.readUntil("\"frames\":99");
  EXPECT_NE(next.find("id: 8\n"), std::string::npos);
  EXPECT_EQ(next.find("id: 7\n"), std::string::npos) << "that was seen";
}

TEST_F(OnASocket, StreamsAndConnectionsAreBounded) {
  std::vector<std::unique_ptr<WebClient>> pages;
  for (int i = 0; i < LiveSite::maxStreams; ++i) {
    pages.push_back(std::make_unique<WebClient>(port()));
    pages.back()->send(head("GET /api/events") + "\r\n");
    ASSERT_NE(pages.back()->readUntil("\r\n\r\n").find("200 OK"), std::string::npos) << i;
  }
  EXPECT_EQ(fetchWeb(port(), "/api/events").status, 503);
  expectAlive();
  std::vector<std::unique_ptr<WebClient>> idle;
  for (int i = 0; i < 100; ++i) idle.push_back(std::make_unique<WebClient>(port()));
  EXPECT_EQ(idle.back()->read().status, 503);
  idle.clear();
  pages.clear();
  for (int i = 0; i < 500; ++i) {  // closed connections make room
    const int status = [&] {
      WebClient client(port());
      client.send(head("GET /api/events") + "\r\n");
      const std::string start = client.readUntil("\r\n\r\n");
      return start.find("200 OK") != std::string::npos ? 200 : 503;
    }();
    if (status == 200) return;
    usleep(20'000);
  }
  FAIL() << "the streams of pages that have gone are kept";
}

TEST(PageServer, SaysWhereItCannotListen) {
  FakeView view;
  const PageServer first(view, optionsAt());
  EXPECT_THAT([&] { PageServer(view, optionsAt(first.port())); }, FailsWith(ErrorCode::network));
  EXPECT_THAT([&] { PageServer(view, optionsAt(70'000)); }, FailsWith(ErrorCode::invalidOption));
  ServerOptions options = optionsAt();
  options.listen = "no such address";
  EXPECT_THAT([&] { PageServer(view, options); }, FailsWith(ErrorCode::network));
}

TEST(PageServer, TakesAnotherPortWhereNoneWasAskedFor) {
  FakeView view;
  const PageServer first(view, {}), second(view, {});
  EXPECT_NE(first.port(), second.port());
  EXPECT_EQ(fetchWeb(second.port(), "/api/where").status, 200);
}

TEST(PageServer, ListensToOthersOnlyWithAToken) {
  FakeView view;
  ServerOptions options = optionsAt();
  options.listen = "127.0.0.1";
  const PageServer server(view, options), other(view, options);
  const std::size_t at = server.url().find("?token=");
  ASSERT_NE(at, std::string::npos);
  const std::string token = server.url().substr(at + 7);
  EXPECT_EQ(token.size(), 32U);
  EXPECT_EQ(other.url().find(token), std::string::npos);
  EXPECT_EQ(fetchWeb(server.port(), "/api/where").status, 401);
  const WebAnswer page = fetchWeb(server.port(), "/?token=" + token);
  EXPECT_EQ(page.status, 200);
  const std::string cookie = page.headers.at("set-cookie");
  for (const char* attribute : {"HttpOnly", "SameSite=Strict"})
    EXPECT_NE(cookie.find(attribute), std::string::npos) << attribute;
  const std::string pair = cookie.substr(0, cookie.find(';'));
  EXPECT_EQ(fetchWeb(server.port(), "/api/where", "Cookie: a=b; " + pair + "\r\n").status, 200);
  EXPECT_EQ(fetchWeb(server.port(), "/api/where", "Authorization: Bearer " + token + "\r\n").status, 200);
}

TEST(PageServer, LeavesTheProgramsSignalsAlone) {
  FakeView view;
  const PageServer server(view, optionsAt());
  struct sigaction now {};
  sigaction(SIGPIPE, nullptr, &now);
  EXPECT_EQ(now.sa_handler, SIG_DFL);
}

}  // namespace
}  // namespace estancia
