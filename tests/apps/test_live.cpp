// Runs that take their time: live ones and those that are stopped, kindly or not.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/json_of.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/shape_drive.hpp"
#include "support/signaled_command.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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
    return signalCommand(
        command("0.5"), scratch_ / "cache", [this] { return fs::exists(map_); },
        std::chrono::milliseconds(50), signal);
  }

  static constexpr int frames = 200;  // 40 s at half the pace
  const WithoutWordNet names_;        // which would be read by each command
  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "live.estancia";
};

TEST_F(LiveCommand, MapsARecordingAndTellsOfEachFrame) {
  const std::vector<json> told = jsonLinesOf(run(command("0"), {"--json"}));
  ASSERT_EQ(told.size(), frames + 1U);
  EXPECT_EQ(told[0]["frame"], "1000.png");
  EXPECT_EQ(told[0]["words"][0]["word"], "word 0");
  EXPECT_EQ(told[25]["words"][0]["word"], "word 1");
  EXPECT_NE(told[15]["place"], told[25]["place"]);
  EXPECT_GT(told[15]["latency_ms"], 0);
  EXPECT_EQ(told.back()["frames"], frames);
  EXPECT_EQ(told.back()["dropped"], 0);
  EXPECT_EQ(readMap(map_).frames.size(), static_cast<std::size_t>(frames));

  const CommandResult again = run({"live", scratch_ / "images", "--localize", map_, "--model",
                                   scratch_ / "model", "--rate", "0", "--no-page"});
  ASSERT_EQ(again.exitCode, 0) << again.err;
}

TEST_F(LiveCommand, GoesOnAfterItWasKilled) {
  EXPECT_TRUE(WIFSIGNALED(signaled(SIGKILL)));
  const TopologicalMap kept = readMap(map_);
  ASSERT_FALSE(kept.frames.empty());
  EXPECT_LT(kept.frames.size(), static_cast<std::size_t>(frames));
  const CommandResult later = run(command("0"));
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
  EXPECT_FALSE(json::parse(asked.out)["result"]["tools"].empty());
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
  jsonOf(run({"objects", "name", map_, "0", "Ana's desk", "--json"}));
  EXPECT_EQ(readWorld(map_).objects[0].givenName, "Ana's desk");
  EXPECT_EQ(json::parse(run({"objects", "list", map_, "--json"}).out)["objects"].size(), 1U);
  EXPECT_EQ(run({"objects", "name", map_, "9", "cup"}).exitCode, 2);
  const CommandResult deleted = run({"objects", "delete", map_, "Ana's desk"});
  ASSERT_EQ(deleted.exitCode, 0) << deleted.err;
  EXPECT_TRUE(readWorld(map_).objects.empty());
}

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
