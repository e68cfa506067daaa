// Downloads from a server on this machine that behaves well, badly, or not at all.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <random>
#include <tuple>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/fetch/download.hpp"
#include "estancia/fetch/partial_file.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {
namespace fs = std::filesystem;

using test::FailsWith;
using test::httpAnswer;
using test::HttpRequest;
using test::LoopbackServer;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;

std::string pattern(std::size_t size, std::size_t seed) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) text += static_cast<char>((i * 31 + seed * 7 + i / 251) % 256);
  return text;
}

class Download : public testing::Test {
 protected:
  Download() {
    test::withoutProxy();
    options_.pauseSeconds = 0;
  }

  test::Caught get(const RemoteFile& file) {
    return test::caught([&] { download(file, target_, options_); });
  }
  RemoteFile known(std::vector<std::string> urls) const {
    RemoteFile file;
    file.urls = std::move(urls);
    file.sha256 = sha256(body_);
    return file;
  }
  static RemoteFile unknown(const std::string& url) {
    RemoteFile file;
    file.urls = {url};
    return file;
  }
  std::vector<std::string> left() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(scratch_.path()))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
  static std::string header(const HttpRequest& request, const std::string& name) {
    const auto found = request.headers.find(name);
    return found == request.headers.end() ? "" : found->second;
  }

  test::ScratchFolder scratch_;
  const fs::path target_ = scratch_ / "net.onnx";
  const std::string body_ = pattern(300'000, 1), other_ = pattern(300'000, 2);
  DownloadOptions options_;
};

TEST_F(Download, LeavesAFileAloneThatIsThereAndRight) {
  LoopbackServer server([&](auto&) { return test::HttpAnswer{httpAnswer("404 Not Found", "")}; });
  writeFile(target_, body_);
  EXPECT_EQ(get(known({server.url("/a")})).code, std::nullopt);
  EXPECT_TRUE(server.requests().empty());
  writeFile(target_, other_);
  EXPECT_THAT(get(known({server.url("/a")})), FailsWith(ErrorCode::network));
  EXPECT_EQ(readFile(target_), other_) << "what the user has put there is not taken away";
}

TEST_F(Download, GoesOnInALaterRun) {
  bool well = false;
  LoopbackServer server([&](const HttpRequest& request) -> test::HttpAnswer {
    if (well) return {test::rangeAnswer(request, body_, "\"v1\"")};
    if (request.headers.contains("range")) return {httpAnswer("503 Service Unavailable", "")};
    return {test::cutAnswer(body_, 200'000, {"ETag: \"v1\""})};
  });
  EXPECT_THAT(get(unknown(server.url("/a"))), FailsWith(ErrorCode::network));
  EXPECT_THAT(left(), ElementsAre("net.onnx.part", "net.onnx.part.from"));
  well = true;
  EXPECT_EQ(get(unknown(server.url("/a"))).code, std::nullopt);
  EXPECT_EQ(readFile(target_), body_);
  EXPECT_EQ(header(server.requests().back(), "range"), "bytes=200000-");
}

TEST_F(Download, GoesOnWithAnEarlierPartOnlyAsFarAsItIsVouchedFor) {
  using Ranges = std::vector<std::string>;
  const std::string foreign = other_.substr(0, 50'000), own = body_.substr(0, 50'000);
  LoopbackServer server(
      [&](const HttpRequest& request) -> test::HttpAnswer { return {test::rangeAnswer(request, body_)}; });
  const std::tuple<std::string, RemoteFile, Ranges> cases[] = {
      {foreign, unknown(server.url("/a")), {""}},
      {own, known({server.url("/a")}), {"bytes=50000-"}},
      {foreign, known({server.url("/a")}), {"bytes=50000-", ""}},
      {body_ + "and more", known({server.url("/a")}), {"bytes=300008-", ""}}};
  for (const auto& [part, file, ranges] : cases) {
    const std::size_t before = server.requests().size();
    writeFile(target_.string() + ".part", part);
    EXPECT_EQ(get(file).code, std::nullopt);
    EXPECT_EQ(readFile(target_), body_);
    Ranges asked;
    for (const HttpRequest& request : server.requests()) asked.push_back(header(request, "range"));
    asked.erase(asked.begin(), asked.begin() + static_cast<std::ptrdiff_t>(before));
    EXPECT_EQ(asked, ranges) << part.size();
    fs::remove(target_);
  }
}

TEST_F(Download, GoesOnWhereTheConnectionBrokeButDoesNotGlueTwoVersionsTogether) {
  enum class Server { good, withoutVersions, withoutRanges, changed, gluing };
  for (const Server kind :
       {Server::good, Server::withoutVersions, Server::withoutRanges, Server::changed, Server::gluing}) {
    SCOPED_TRACE(static_cast<int>(kind));
    const bool isChanged = kind == Server::changed || kind == Server::gluing;
    const std::string etag = kind == Server::withoutVersions ? "" : "\"v1\"";
    int times = 0;
    LoopbackServer server([&](HttpRequest request) -> test::HttpAnswer {
      if (times++ == 0)
        return {test::cutAnswer(body_, 100'000,
                                etag.empty() ? std::vector<std::string>{} : std::vector{"ETag: " + etag})};
      if (kind == Server::withoutRanges) return {httpAnswer("200 OK", body_)};
      if (kind == Server::gluing) request.headers.erase("if-range");
      return {test::rangeAnswer(request, isChanged ? other_ : body_, isChanged ? "\"v2\"" : etag)};
    });
    const auto error =
        get(kind == Server::withoutVersions ? known({server.url("/a")}) : unknown(server.url("/a")));
    EXPECT_EQ(header(server.requests().at(1), "range"), "bytes=100000-");
    EXPECT_EQ(header(server.requests().at(1), "if-range"), etag);
    EXPECT_TRUE(kind != Server::good || server.requests().size() == 2) << "one request goes on";
    if (kind == Server::gluing)
      EXPECT_THAT(error, FailsWith(ErrorCode::network));
    else
      EXPECT_EQ(readFile(target_), isChanged ? other_ : body_) << error;
    for (const std::string& name : left()) fs::remove(scratch_ / name);
  }
}

TEST_F(Download, StopsWhenTheUserWantsTo) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto stopped = [&] {
    std::signal(SIGINT, SIG_DFL);
    catchInterrupts();
    test::Caught error;
    {
      LoopbackServer server([&](auto&) {
        std::raise(SIGINT);
        return test::HttpAnswer{test::cutAnswer(body_, 200'000, {"ETag: \"v1\""}), true};
      });
      error = get(unknown(server.url("/a")));
    }
    std::exit(error.code == ErrorCode::interrupted && !fs::exists(target_) ? 7 : 1);
  };
  EXPECT_EXIT(stopped(), testing::ExitedWithCode(7), "");
}

TEST_F(Download, RefusesAnAnswerToAnotherRange) {
  writeFile(target_.string() + ".part", body_.substr(0, 50'000));
  LoopbackServer server([&](auto&) -> test::HttpAnswer {
    return {httpAnswer("206 Partial Content", body_.substr(10), {"Content-Range: bytes 10-299999/300000"})};
  });
  EXPECT_THAT(get(known({server.url("/a")})), FailsWith(ErrorCode::network));
  EXPECT_THAT(get(unknown(server.url("/a"))), FailsWith(ErrorCode::network)) << "no part was asked for";
}

TEST_F(Download, DiscardsWhatHasTheWrongDigest) {
  LoopbackServer server([&](auto&) { return test::HttpAnswer{httpAnswer("200 OK", other_)}; });
  EXPECT_THAT(get(known({server.url("/a")})), FailsWith(ErrorCode::network));
  EXPECT_TRUE(left().empty());
}

TEST_F(Download, GivesUpOnAServerThatStopsSending) {
  options_.stallSeconds = 1;
  LoopbackServer server([&](auto&) { return test::HttpAnswer{test::cutAnswer(body_, 1000), true}; });
  EXPECT_THAT(get(unknown(server.url("/a"))), FailsWith(ErrorCode::network));
}

TEST_F(Download, AsksAnIllServerAgainButNotForWhatIsNotThere) {
  LoopbackServer server([&](const HttpRequest& request) -> test::HttpAnswer {
    if (request.path == "/ssh") return {"SSH-2.0-OpenSSH_9.2p1 Debian-2\r\n"};
    if (request.path == "/nothing") return {""};
    return {httpAnswer(request.path == "/gone" ? "404 Not Found" : "500 Internal Server Error", "sorry")};
  });
  EXPECT_THAT(get(unknown(server.url("/gone"))), FailsWith(ErrorCode::network));
  EXPECT_EQ(server.requests().size(), 1U);
  EXPECT_THAT(get(unknown(server.url("/ill"))), FailsWith(ErrorCode::network));
  EXPECT_EQ(server.requests().size(), 4U);
  for (const char* path : {"/ssh", "/nothing"})
    EXPECT_THAT(get(unknown(server.url(path))), FailsWith(ErrorCode::network)) << "this is not HTTP";
  EXPECT_TRUE(left().empty());
}

TEST_F(Download, TriesTheMirrorsInOrder) {
  LoopbackServer server([&](const HttpRequest& request) -> test::HttpAnswer {
    if (request.path == "/1") return {httpAnswer("404 Not Found", "")};
    if (request.path == "/2") return {httpAnswer("200 OK", "<html>log in to this network</html>")};
    return {httpAnswer("200 OK", body_)};
  });
  EXPECT_EQ(get(known({server.url("/1"), server.url("/2"), server.url("/3"), server.url("/4")})).code,
            std::nullopt);
  EXPECT_EQ(readFile(target_), body_);
  EXPECT_EQ(server.requests().size(), 3U);
}

TEST_F(Download, SaysHowToGoOnWithoutANetwork) {
  std::string url;
  {
    const LoopbackServer server([](auto&) { return test::HttpAnswer{}; });
    url = server.url("/net.onnx");
  }  // no server listens there any more
  EXPECT_THAT(get(unknown(url)), FailsWith(ErrorCode::network, url, target_.string()));
  EXPECT_THAT(get(unknown("http://host.invalid/net.onnx")), FailsWith(ErrorCode::network, "host.invalid"));
}

TEST_F(Download, FollowsRedirectsButNotForEverNorAnywhere) {
  writeFile(scratch_ / "secret", "secret");
  LoopbackServer server([&](const HttpRequest& request) -> test::HttpAnswer {
    const auto to = [](const std::string& where) {
      return test::HttpAnswer{httpAnswer("302 Found", "moved", {"Location: " + where})};
    };
    if (request.path == "/moved") return to("/net.onnx");
    if (request.path == "/circle") return to("/circle");
    if (request.path == "/file") return to("file://" + (scratch_ / "secret").string());
    return {httpAnswer("200 OK", body_)};
  });
  EXPECT_THAT(get(unknown(server.url("/circle"))), FailsWith(ErrorCode::network));
  EXPECT_LE(server.requests().size(), 10U);
  EXPECT_THAT(get(unknown(server.url("/file"))), FailsWith(ErrorCode::network));
  EXPECT_FALSE(fs::exists(target_));
  EXPECT_EQ(get(known({server.url("/moved")})).code, std::nullopt);
}

TEST_F(Download, RefusesFilesOfAnotherSize) {
  LoopbackServer server([&](const HttpRequest& request) -> test::HttpAnswer {
    if (request.path == "/chunked")
      return {"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n5\r\nworld\r\n0\r\n\r\n"};
    return {httpAnswer("200 OK", body_)};
  });
  RemoteFile file = unknown(server.url("/a"));
  file.size = 1000;
  EXPECT_THAT(get(file), FailsWith(ErrorCode::network));
  file.urls = {server.url("/chunked")};
  file.size = 7;
  EXPECT_THAT(get(file), FailsWith(ErrorCode::network));
  file.size = 11;
  EXPECT_THAT(get(file), FailsWith(ErrorCode::network));
  options_.maxBytes = 9;
  EXPECT_THAT(get(unknown(server.url("/chunked"))), FailsWith(ErrorCode::network));
  EXPECT_THAT(get(unknown(server.url("/a"))), FailsWith(ErrorCode::network));
  EXPECT_FALSE(fs::exists(target_));
  EXPECT_THAT(left(), testing::IsEmpty()) << "what an endless server has sent";
}

TEST_F(Download, KeepsOutOfTheWayOfAnotherProcess) {
  LoopbackServer server([&](auto&) { return test::HttpAnswer{httpAnswer("200 OK", body_)}; });
  const PartialFile busy(target_);
  EXPECT_THAT(get(unknown(server.url("/a"))), FailsWith(ErrorCode::busy));
}

class ArchiveMember : public testing::Test {
 protected:
  ArchiveMember() {
    writeFile(scratch_ / "in/folder/net.prototxt", "layers");
    writeFile(scratch_ / "in/folder/empty", "");
    writeFile(scratch_ / "in/other.prototxt", "others");
    std::string noise;
    for (std::mt19937 random(1); noise.size() < 20'000;) noise += static_cast<char>(random());
    writeFile(scratch_ / "in/noise", noise);
    fs::create_symlink("/etc/passwd", scratch_ / "in/link");
    const std::string command =
        "tar -C '" + (scratch_ / "in").string() + "' -czf '" + archive_.string() + "' .";
    EXPECT_EQ(std::system(command.c_str()), 0);
  }
  bool take(const std::string& name, std::uint64_t most = 1000) const {
    return extractMember(archive_, name, target_, most);
  }

  test::ScratchFolder scratch_;
  const fs::path archive_ = scratch_ / "a.tar.gz", target_ = scratch_ / "out";
};

TEST_F(ArchiveMember, IsTakenByItsNameOrPathUpToALimit) {
  EXPECT_THAT([&] { take("net.prototxt", 5); }, FailsWith(ErrorCode::tooLarge));
  EXPECT_FALSE(fs::exists(target_) || fs::exists(scratch_ / "out.part"));
  EXPECT_TRUE(take("net.prototxt"));
  EXPECT_EQ(readFile(target_), "layers");
  EXPECT_TRUE(take("folder/empty"));
  EXPECT_EQ(readFile(target_), "");
  EXPECT_FALSE(take("prototxt")) << "a part of a name is not the name";
}

TEST_F(ArchiveMember, OfADamagedArchiveIsRefused) {
  const std::string whole = readFile(archive_);
  for (const std::string& bytes : {whole.substr(0, whole.size() / 2), std::string("<html>log in</html>"),
                                   std::string(1000, '\0'), pattern(5000, 3)}) {
    writeFile(archive_, bytes);
    bool taken = true;
    const auto error = test::caught([&] { taken = take("nothing"); });
    EXPECT_TRUE(error.code || !taken);
    EXPECT_FALSE(fs::exists(target_));
  }
  const std::string noise = readFile(scratch_ / "in/noise");
  for (std::size_t size = 0; size < whole.size(); size += 501) {
    writeFile(archive_, whole.substr(0, size));
    const auto error = test::caught([&] { take("noise", 1 << 20); });
    if (fs::exists(target_))
      EXPECT_EQ(readFile(target_), noise) << size;
    else
      EXPECT_THAT(error, FailsWith(ErrorCode::malformedFile)) << size;
    fs::remove(target_);
  }
  EXPECT_THAT([&] { extractMember(scratch_ / "none", "a", target_, 9); },
              FailsWith(ErrorCode::malformedFile));
}

TEST_F(Download, TakesACompletePartWithoutAskingAgain) {
  writeFile(target_.string() + ".part", body_);
  LoopbackServer server([&](auto&) { return test::HttpAnswer{httpAnswer("404 Not Found", "")}; });
  RemoteFile file = known({server.url("/a")});
  file.size = body_.size();
  EXPECT_EQ(get(file).code, std::nullopt);
  EXPECT_TRUE(server.requests().empty());
}

}  // namespace
}  // namespace estancia
