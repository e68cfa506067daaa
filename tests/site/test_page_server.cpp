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
using test::WebAnswer;
using test::WebClient;
using testing::HasSubstr;
using Json = nlohmann::json;

class OnASocket : public testing::Test {
 protected:
  static ServerOptions anyPort() {
    ServerOptions options;
    options.port = 0;
    return options;
  }
  std::string head(const std::string& request) const {
    return request + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port()) + "\r\n";
  }
  int port() const { return server_.port(); }
  /// Another client is served still.
  void expectAlive() const { EXPECT_EQ(fetchWeb(port(), "/api/where").status, 200); }

  FakeView view_;
  PageServer server_{view_, anyPort()};
};

TEST_F(OnASocket, ServesPageApiAndImages) {
  const WebAnswer page = fetchWeb(port(), "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.headers.at("content-type"), HasSubstr("text/html"));
  EXPECT_THAT(page.headers.at("content-security-policy"), HasSubstr("script-src 'self'"));
  EXPECT_EQ(page.headers.at("x-content-type-options"), "nosniff");
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
  EXPECT_THAT(client.readUntil("\r\n\r\n"), HasSubstr("200 OK"));
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
    EXPECT_THAT(answer.body, testing::HasSubstr("one Content-Length")) << length;
  }
  {  // chunks say no length beforehand
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
  {
    WebClient client(port());
    client.send("GET /" + std::string(20'000, 'a') + " HTTP/1.1\r\n\r\n");
    EXPECT_NE(client.read().status, 200);
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
  for (const std::string& bytes :
       {std::string("\r\n\r\n"), std::string("garbage\r\n\r\n"), std::string("GET\r\n\r\n"),
        std::string(5000, '\0'), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11),
        head("GET /api/where") + "Range: bytes=" +
            [] {
              std::string ranges;
              for (int i = 0; i < 1500; ++i) ranges += "0-,";
              return ranges + "0-";
            }() +
            "\r\n\r\n",
        head("GET /%00%0a") + "\r\n", head("GET /api/ask?words=%FF%FE") + "\r\n",
        head("GET /api/ask?words=" + std::string(4000, 'a')) + "\r\n"}) {
    WebClient client(port());
    client.send(bytes);
    client.finish();
    const WebAnswer answer = client.read();
    EXPECT_LT(answer.body.size(), 10'000U);
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
    EXPECT_THAT(pages[i]->readUntil("event: status\n"), HasSubstr("text/event-stream"));
  const std::string longName(20'000, 'x');  // the one that does not read is full soon
  for (std::uint64_t revision = 8; revision < 20; ++revision) {
    view_.change(
        [&](LiveStatus& status, auto&) { status.decision = longName + std::to_string(revision) + "."; });
    for (std::size_t i = 1; i < pages.size(); ++i)
      EXPECT_THAT(pages[i]->readUntil(longName + std::to_string(revision) + "."), HasSubstr("xxx")) << i;
  }
  expectAlive();
}

TEST_F(OnASocket, AStreamGoesOnWhereItWas) {
  WebClient client(port());
  client.send(head("GET /api/events") + "Last-Event-ID: 7\r\n\r\n");
  EXPECT_THAT(client.readUntil("retry: 1000"), HasSubstr("200 OK"));
  view_.change([](LiveStatus& status, auto&) { status.frames = 99; });
  const std::string next = client.readUntil("\"frames\":99");
  EXPECT_THAT(next, HasSubstr("id: 8\n"));
  EXPECT_THAT(next, testing::Not(HasSubstr("id: 7\n"))) << "that was seen";
}

TEST_F(OnASocket, StreamsAndConnectionsAreBounded) {
  std::vector<std::unique_ptr<WebClient>> pages;
  for (int i = 0; i < LiveSite::mostStreams; ++i) {
    pages.push_back(std::make_unique<WebClient>(port()));
    pages.back()->send(head("GET /api/events") + "\r\n");
    ASSERT_THAT(pages.back()->readUntil("\r\n\r\n"), HasSubstr("200 OK")) << i;
  }
  EXPECT_EQ(fetchWeb(port(), "/api/events").status, 503);
  expectAlive();
  std::vector<std::unique_ptr<WebClient>> idle;
  for (int i = 0; i < 100; ++i) idle.push_back(std::make_unique<WebClient>(port()));
  EXPECT_EQ(idle.back()->read().status, 503);
  idle.clear();
  pages.clear();
  for (int i = 0; i < 500; ++i) {  // those who have gone make room
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
  ServerOptions options;
  options.port = 0;
  const PageServer first(view, options);
  options.port = first.port();
  EXPECT_THAT([&] { PageServer(view, options); },
              FailsWith(ErrorCode::network, std::to_string(first.port())));
  options.port = 70'000;
  EXPECT_THAT([&] { PageServer(view, options); }, FailsWith(ErrorCode::invalidOption));
  options = {};
  options.port = 0;
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
  ServerOptions options;
  options.port = 0;
  options.listen = "127.0.0.1";
  const PageServer server(view, options), other(view, options);
  const std::size_t at = server.url().find("?token=");
  ASSERT_NE(at, std::string::npos);
  const std::string token = server.url().substr(at + 7);
  EXPECT_EQ(token.size(), 32U);
  EXPECT_THAT(other.url(), testing::Not(HasSubstr(token)));
  EXPECT_EQ(fetchWeb(server.port(), "/api/where").status, 401);
  const WebAnswer page = fetchWeb(server.port(), "/?token=" + token);
  EXPECT_EQ(page.status, 200);
  const std::string cookie = page.headers.at("set-cookie");
  EXPECT_THAT(cookie, testing::AllOf(HasSubstr("HttpOnly"), HasSubstr("SameSite=Strict")));
  const std::string pair = cookie.substr(0, cookie.find(';'));
  EXPECT_EQ(fetchWeb(server.port(), "/api/where", "Cookie: a=b; " + pair + "\r\n").status, 200);
  EXPECT_EQ(fetchWeb(server.port(), "/api/where", "Authorization: Bearer " + token + "\r\n").status, 200);
}

TEST(PageServer, LeavesTheProgramsSignalsAlone) {
  FakeView view;
  ServerOptions options;
  options.port = 0;
  const PageServer server(view, options);
  struct sigaction now {};
  sigaction(SIGPIPE, nullptr, &now);
  EXPECT_EQ(now.sa_handler, SIG_DFL);
}

}  // namespace
}  // namespace estancia
