// estancia live: recordings that are played, runs that are killed or interrupted, wrong arguments.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>

#include "estancia/world_file/world_map.hpp"
#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class LiveCommand : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scratch_ / "images");
    writeColorModel(scratch_ / "model");
    for (int i = 0; i < frames; ++i) {
      const bool red = i / 20 % 2 == 0;
      cv::imwrite(scratch_ / "images" / (std::to_string(1000 + i) + ".png"),
                  cv::Mat(24, 32, CV_8UC3, red ? cv::Scalar(0, 0, 200) : cv::Scalar(200, 0, 0)));
    }
  }
  std::vector<std::string> command(const std::string& rate) const {
    return {"live", scratch_ / "images", "-o", map_, "--model", scratch_ / "model", "--rate",
            rate,   "--no-page"};
  }
  /// Starts it, and sends it a signal as soon as it has written. Returns how it ended.
  int signaled(int signal) const {
    std::vector<std::string> words = command("0.5");
    words.insert(words.begin(), ESTANCIA_COMMAND);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      execv(ESTANCIA_COMMAND, arguments.data());
      _exit(127);
    }
    for (int i = 0; i < 600 && !fs::exists(map_); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }

  static constexpr int frames = 200;  // 40 s at half the pace
  const WithoutWordNet names_;        // which would be read by each command
  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "live.estancia";
};

TEST_F(LiveCommand, MapsARecordingAndTellsOfEachFrame) {
  std::vector<std::string> words = command("0");
  words.push_back("--json");
  const CommandResult run = test::run(words);
  ASSERT_EQ(run.exitCode, 0) << run.err;
  std::istringstream lines(run.out);
  std::vector<Json> told;
  for (std::string line; std::getline(lines, line);) told.push_back(Json::parse(line));
  ASSERT_EQ(told.size(), frames + 1U);
  EXPECT_EQ(told[0]["frame"], "1000.png");
  EXPECT_EQ(told[0]["words"][0]["word"], "word 0");
  EXPECT_EQ(told[25]["words"][0]["word"], "word 1");
  EXPECT_NE(told[15]["place"], told[25]["place"]);
  EXPECT_GT(told[15]["latency_ms"], 0);
  EXPECT_EQ(told.back()["frames"], frames);
  EXPECT_EQ(told.back()["dropped"], 0);
  EXPECT_EQ(readMap(map_).frames.size(), static_cast<std::size_t>(frames));

  const CommandResult again = test::run({"live", scratch_ / "images", "--localize", map_, "--model",
                                         scratch_ / "model", "--rate", "0", "--no-page"});
  ASSERT_EQ(again.exitCode, 0) << again.err;
}

TEST_F(LiveCommand, GoesOnAfterItWasKilled) {
  EXPECT_TRUE(WIFSIGNALED(signaled(SIGKILL)));
  const TopologicalMap kept = readMap(map_);
  ASSERT_FALSE(kept.frames.empty());
  EXPECT_LT(kept.frames.size(), static_cast<std::size_t>(frames));
  const CommandResult later = test::run(command("0"));
  ASSERT_EQ(later.exitCode, 0) << later.err;
  // None of the rest is missing, none is there twice. Before, a busy machine left some out: it played in
  // time.
  std::vector<std::string> expected;
  for (const MappedFrame& frame : kept.frames) expected.push_back(frame.name);
  for (int i = std::stoi(expected.back()) + 1; i < 1000 + frames; ++i)
    expected.push_back(std::to_string(i) + ".png");
  std::vector<std::string> found;
  for (const MappedFrame& frame : readMap(map_).frames) found.push_back(frame.name);
  EXPECT_EQ(found, expected);
}

TEST_F(LiveCommand, EndsWholeWhenItIsInterrupted) {
  const int status = signaled(SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_FALSE(fs::exists(map_ + "-wal"));
  const WorldMap world = readWorld(map_);
  EXPECT_GT(world.places.frames.size(), 0U);
  EXPECT_FALSE(world.zones.empty()) << "what takes long at the end is not left out";
}

TEST_F(LiveCommand, StandardOutputIsTheAgentsAlone) {
  std::vector<std::string> words = command("0");
  words.insert(words.begin(),
               {"-c", R"(map=$1; shift; { echo '{"jsonrpc": "2.0", "id": 1, "method": "tools/list"}';
                                   while [ ! -e "$map" ]; do sleep 0.05; done; } | "$0" "$@")",
                ESTANCIA_COMMAND, map_});
  words.push_back("--mcp");
  const CommandResult asked = runProgram("/bin/sh", words);
  EXPECT_EQ(asked.exitCode, 0) << asked.err << "an agent that goes ends the run";
  EXPECT_EQ(std::ranges::count(asked.out, '\n'), 1);
  EXPECT_FALSE(Json::parse(asked.out)["result"]["tools"].empty());
}

TEST_F(LiveCommand, RefusesWhatItCannotUse) {
  const std::string images = scratch_ / "images", model = scratch_ / "model";
  const std::string bad = scratch_ / "bad.estancia";
  std::ofstream(bad) << "no map";
  const std::vector<std::pair<std::vector<std::string>, ErrorCode>> refused{
      {{"live", images}, ErrorCode::invalidOption},  // neither -o nor --localize
      {{"live", images, "-o", map_, "--localize", map_}, ErrorCode::invalidOption},
      {{"live", images, "-o", map_, "--rate", "-1"}, ErrorCode::invalidOption},
      {{"live", scratch_ / "nowhere", "-o", map_, "--model", model}, ErrorCode::fileNotFound},
      {{"live", bad}, ErrorCode::truncatedFile},
      {{"live", scratch_ / "none.estancia"}, ErrorCode::fileNotFound}};
  for (const auto& [arguments, code] : refused)
    EXPECT_THAT(run(arguments), FailsWith(code)) << testing::PrintToString(arguments);
  for (const auto& entry : fs::directory_iterator(images)) std::ofstream(entry.path()) << "text";
  EXPECT_EQ(run(command("0")).exitCode, 2) << "nothing could be mapped";
  EXPECT_FALSE(fs::exists(map_));
}

TEST_F(LiveCommand, ObjectsAreListedNamedAndDeleted) {
  mapShapes(ShapeDrive(desk), 8, map_, {});
  const CommandResult named = run({"objects", "name", map_, "0", "Ana's desk", "--json"});
  ASSERT_EQ(named.exitCode, 0) << named.err;
  EXPECT_EQ(readWorld(map_).objects[0].givenName, "Ana's desk");
  EXPECT_EQ(Json::parse(run({"objects", "list", map_, "--json"}).out)["objects"].size(), 1U);
  EXPECT_EQ(run({"objects", "name", map_, "9", "cup"}).exitCode, 2);
  const CommandResult deleted = run({"objects", "delete", map_, "Ana's desk"});
  ASSERT_EQ(deleted.exitCode, 0) << deleted.err;
  EXPECT_TRUE(readWorld(map_).objects.empty());
}

}  // namespace
}  // namespace estancia::test
