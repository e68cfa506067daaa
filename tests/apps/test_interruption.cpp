// What becomes of a map when its process is stopped, kindly or not.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/model_support.hpp"
#include "support/signaled_command.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Starts `estancia map` of many panorama views, waits until the map file has been there for a while, sends
/// `signal`. Returns the wait status.
int mapUntilSignaled(const std::vector<std::string>& arguments, const fs::path& file, int signal) {
  // Labels of earlier runs would have it done before the signal comes.
  return signalCommand(
      arguments, file.parent_path() / "cache", [&] { return fs::exists(file); },
      std::chrono::milliseconds(500), signal);
}

class Interruption : public testing::Test {
 protected:
  void SetUp() override {
    panoramas_ = findFetched("panoramas");
    ESTANCIA_NEEDS(panoramas_, "the panoramas are not here; script/bootstrap fetches them");
    writeSmallModel(scratch_ / "model");
  }
  std::vector<std::string> mapTo(const std::string& file, const std::string& more = "") const {
    std::vector<std::string> arguments{"map",     panoramas_->string(), "-o",      scratch_ / file,
                                       "--model", scratch_ / "model",   "--views", "100"};
    if (!more.empty()) arguments.push_back(more);
    return arguments;
  }
  std::string exported(const std::string& file) const {
    return run({"export", scratch_ / file, "--format", "json"}).out;
  }
  static std::size_t frames(const std::string& places) {
    std::size_t count = 0;
    const json parsed = json::parse(places);
    for (const auto& place : parsed["places"]) count += place["frames"].get<std::size_t>();
    return count;
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  std::optional<fs::path> panoramas_;
};

TEST_F(Interruption, AKilledRunGoesOnAndEndsInTheSameMap) {
  const int status = mapUntilSignaled(mapTo("killed.estancia"), scratch_ / "killed.estancia", SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status)) << "it had finished before it could be killed";
  const std::size_t kept = frames(exported("killed.estancia"));
  EXPECT_GT(kept, 0U);
  EXPECT_LT(kept, 1800U);
  const auto continued = run(mapTo("killed.estancia", "--continue"));
  ASSERT_EQ(continued.exitCode, 0) << continued.err;
  ASSERT_EQ(run(mapTo("whole.estancia")).exitCode, 0);
  EXPECT_EQ(exported("killed.estancia"), exported("whole.estancia"));
  EXPECT_EQ(frames(exported("whole.estancia")), 1800U);
}

TEST_F(Interruption, CtrlCAndAClosedTerminalKeepWhatIsDone) {
  for (const int signal : {SIGINT, SIGHUP}) {
    const std::string file = signal == SIGINT ? "stopped.estancia" : "closed.estancia";
    const int status = mapUntilSignaled(mapTo(file), scratch_ / file, signal);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_GT(frames(exported(file)), 0U);
    EXPECT_FALSE(fs::exists(scratch_ / (file + "-wal")));
  }
}

/// A run with a program as labeler that takes its time, its images in a temporary folder of our own.
class ProgramOfARun : public testing::Test {
 protected:
  void SetUp() override {
    writeFile(scratch_ / "model/model.toml",
              "name = \"mine\"\ntype = \"process\"\ncommand = [\"sh\", \"labeler.sh\"]\n");
    writeFile(scratch_ / "model/labeler.sh",
              "sleep 1000 & echo $! >../sleeper; echo $$ >../program\n"
              "while read -r image; do [ -e ../quick ] || sleep 1\n"
              "printf '{\"image\": \"%s\", \"labels\": {\"cup\": 1}}\\n' \"$image\"; done\n"
              "exec sleep 1000\n");
    fs::create_directories(scratch_ / "images");
    for (const char* name : {"1.png", "2.png", "3.png", "4.png"})
      cv::imwrite(scratch_ / "images" / name, cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(90)));
    fs::create_directory(temporary_);
    setenv("TMPDIR", temporary_.c_str(), 1);
  }
  void TearDown() override { unsetenv("TMPDIR"); }

  int mapUntil(int signal) const { return mapUntilSignaled(arguments_, scratch_ / "program", signal); }
  void expectNoProcessIsLeft() const {
    EXPECT_FALSE(livesOn(scratch_ / "program"));
    EXPECT_FALSE(livesOn(scratch_ / "sleeper"));
  }

  const ScratchFolder scratch_;
  const fs::path temporary_ = scratch_ / "tmp";
  const std::vector<std::string> arguments_{"map",     scratch_ / "images", "-o", scratch_ / "home.estancia",
                                            "--model", scratch_ / "model"};
};

TEST_F(ProgramOfARun, EndsWithItWhenTheTerminalIsClosed) {
  const int status = mapUntil(SIGHUP);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  expectNoProcessIsLeft();
  EXPECT_TRUE(fs::is_empty(temporary_));
}

TEST_F(ProgramOfARun, EndsWithItWhenItIsKilledAndTheNextRunTidiesUp) {
  ASSERT_TRUE(WIFSIGNALED(mapUntil(SIGKILL)));
  expectNoProcessIsLeft();
  EXPECT_FALSE(fs::is_empty(temporary_));
  writeFile(scratch_ / "quick", "");
  const auto next = run(arguments_);
  EXPECT_EQ(next.exitCode, 0) << next.err;
  EXPECT_TRUE(fs::is_empty(temporary_));
}

}  // namespace
}  // namespace estancia::test
