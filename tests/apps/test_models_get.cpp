// `estancia models get` as a user runs it: stopped, without a network, on a full disk.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "estancia/core/digest.hpp"
#include "estancia/label/catalog.hpp"
#include "support/errors.hpp"
#include "support/loopback_server.hpp"
#include "support/model_support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

class ModelsGet : public testing::Test {
 protected:
  ModelsGet() {
    withoutProxy();
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  /// Writes a catalog of the model `small`, whose network and labels are at these addresses.
  void list(const std::string& networkUrl, const std::string& labelsUrl) const {
    writeFile(scratch_ / "home/catalog.toml",
              "[labels.four]\ncount = 4\nurls = [\"" + labelsUrl + "\"]\nsha256 = \"" +
                  sha256(labelLines(4)) +
                  "\"\n[models.small]\nabout = \"a test\"\nlicense = \"MIT\"\nsource = \"here\"\n"
                  "labels = \"four\"\n[[models.small.files]]\nname = \"small.onnx\"\nurls = [\"" +
                  networkUrl + "\"]\nsha256 = \"" + sha256(network_) +
                  "\"\n[models.small.model]\nfile = \"small.onnx\"\ninput = 8\ncolor = \"BGR\"\n");
  }
  fs::path part() const { return downloadFolder("small") / "small.onnx.part"; }

  ScratchFolder scratch_;
  const std::string network_ = smallOnnx(8, 4);
};

TEST_F(ModelsGet, ListsWhatCanBeHad) {
  const auto printed = run({"models", "catalog", "--json"});
  const json first = json::parse(printed.out.substr(0, printed.out.find('\n')));
  EXPECT_EQ(first["name"], "clip-vit-b32");
  EXPECT_EQ(first["by_hand"], true);
  EXPECT_EQ(first["installed"], false);
  EXPECT_THAT(run({"models", "get", "resnet"}), FailsWith(ErrorCode::unknownName));
}

TEST_F(ModelsGet, SaysWhatToDoWithoutANetwork) {
  list("http://host.invalid/small.onnx", "http://host.invalid/labels");
  EXPECT_THAT(run({"models", "get", "small"}), FailsWith(ErrorCode::network));
  writeFile(downloadFolder("small") / "small.onnx", network_);
  writeFile(downloadFolder("small") / "four.list", labelLines(4));
  const auto offline = run({"models", "get", "small", "--json"});
  EXPECT_EQ(offline.exitCode, 0) << offline.err;
  EXPECT_EQ(json::parse(offline.out)["labels"], 4);
  EXPECT_EQ(json::parse(run({"models", "list", "--json"}).out)["name"], "small");
}

TEST_F(ModelsGet, CtrlCKeepsWhatHasArrived) {
  std::atomic<bool> slow = true;
  const LoopbackServer server([&](const HttpRequest& request) -> HttpAnswer {
    if (request.path == "/labels") return {httpAnswer("200 OK", labelLines(4))};
    if (slow) return {cutAnswer(network_, 100, {"ETag: \"v1\""}), true};
    return {rangeAnswer(request, network_, "\"v1\"")};
  });
  list(server.url("/small.onnx"), server.url("/labels"));
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open((scratch_ / "said").c_str(), O_RDWR | O_CREAT, 0600);
    for (const int stream : {1, 2}) dup2(nowhere, stream);
    execl(ESTANCIA_COMMAND, ESTANCIA_COMMAND, "models", "get", "small", static_cast<char*>(nullptr));
    _exit(127);
  }
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  std::error_code none;
  while (!(fs::exists(part()) && fs::file_size(part(), none) == 100) &&
         std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_NE(readFile(scratch_ / "said").find("[interrupted]"), std::string::npos);
  EXPECT_EQ(readFile(part()), network_.substr(0, 100));

  slow = false;
  const auto again = run({"models", "get", "small"});
  EXPECT_EQ(again.exitCode, 0) << again.err;
  EXPECT_EQ(server.requests().at(1).headers.at("range"), "bytes=100-");
  EXPECT_FALSE(fs::exists(part()));
}

TEST_F(ModelsGet, AFullDiskKeepsWhatFitted) {
  const LoopbackServer server([&](const HttpRequest& request) -> HttpAnswer {
    return {rangeAnswer(request, std::string(100'000, 'x'), "\"v1\"")};
  });
  list(server.url("/small.onnx"), server.url("/labels"));
  // A limit on the size of files, here 8 blocks of 512 or 1024 bytes, fails as a full disk does.
  const std::string command = "trap '' XFSZ; ulimit -f 8; exec '" ESTANCIA_COMMAND "' models get small 2>'" +
                              (scratch_ / "said").string() + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_NE(readFile(scratch_ / "said").find("[file-unwritable]"), std::string::npos);
  EXPECT_GE(fs::file_size(part()), 4096U);
}

}  // namespace
}  // namespace estancia::test
