// estancia live: recordings that are played, runs that are killed or interrupted, wrong arguments.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>

#include "estancia/world/world_map.hpp"
#include "support/color_model.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

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
  EXPECT_THAT(told[15]["decision"].get<std::string>(), HasSubstr("1015.png"));
  EXPECT_EQ(told.back()["frames"], frames);
  EXPECT_EQ(told.back()["dropped"], 0);
  EXPECT_EQ(readMap(map_).frames.size(), static_cast<std::size_t>(frames));

  const CommandResult again = test::run({"live", scratch_ / "images", "--localize", map_, "--model",
                                         scratch_ / "model", "--rate", "0", "--no-page"});
  ASSERT_EQ(again.exitCode, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("200 frames"));
}

TEST_F(LiveCommand, GoesOnAfterItWasKilled) {
  EXPECT_TRUE(WIFSIGNALED(signaled(SIGKILL)));
  const std::size_t kept = readMap(map_).frames.size();
  EXPECT_GT(kept, 0U);
  EXPECT_LT(kept, static_cast<std::size_t>(frames));
  const CommandResult later = test::run(command("0"));
  ASSERT_EQ(later.exitCode, 0) << later.err;
  const TopologicalMap map = readMap(map_);
  ASSERT_EQ(map.frames.size(), static_cast<std::size_t>(frames)) << "none is missing, none is there twice";
  for (int i = 0; i < frames; ++i)
    EXPECT_EQ(map.frames[static_cast<std::size_t>(i)].name, std::to_string(1000 + i) + ".png");
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

TEST_F(LiveCommand, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(run({"live", scratch_ / "images"}).exitCode, 2) << "neither -o nor --localize";
  EXPECT_EQ(run({"live", scratch_ / "images", "-o", map_, "--localize", map_}).exitCode, 2);
  EXPECT_EQ(run({"live", scratch_ / "images", "-o", map_, "--rate", "-1"}).exitCode, 2);
  const CommandResult nowhere =
      run({"live", scratch_ / "nowhere", "-o", map_, "--model", scratch_ / "model"});
  EXPECT_EQ(nowhere.exitCode, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("file-not-found"));
  EXPECT_FALSE(fs::exists(map_));
}

TEST_F(LiveCommand, ObjectsAreListedNamedAndDeleted) {
  mapShapes(ShapeDrive(desk), 8, map_, {});
  const CommandResult named = run({"objects", "name", map_, "0", "Ana's desk", "--json"});
  ASSERT_EQ(named.exitCode, 0) << named.err;
  EXPECT_THAT(named.out, HasSubstr("Ana's desk"));
  EXPECT_THAT(run({"objects", "list", map_}).out, HasSubstr("Ana's desk"));
  EXPECT_EQ(run({"objects", "name", map_, "9", "cup"}).exitCode, 2);
  const CommandResult deleted = run({"objects", "delete", map_, "Ana's desk"});
  ASSERT_EQ(deleted.exitCode, 0) << deleted.err;
  EXPECT_THAT(deleted.out, HasSubstr("0 objects"));
}

TEST(LiveRooms, AreNamedAtTheEnd) {
  const auto home = findData("home_a");
  ESTANCIA_NEEDS(home, "home_a is missing");
  const auto model = findFetched("models/inception-v3");
  ESTANCIA_NEEDS(model, "the default network is missing; run script/bootstrap");
  const ScratchFolder folder;
  fs::create_directories(folder / "kitchen");
  std::istringstream rooms(readFile(*home / "day/rooms.csv"));
  for (std::string line; std::getline(rooms, line);)
    if (line.find(",kitchen") != std::string::npos) {
      const std::string image = line.substr(0, line.find(','));
      fs::copy_file(*home / "day/rgb" / image, folder / ("kitchen/" + image));
    }
  const std::string map = folder / "kitchen.estancia";
  const CommandResult live = test::run({"live", folder / "kitchen", "-o", map, "--rate", "0", "--no-page"});
  ASSERT_EQ(live.exitCode, 0) << live.err;
  EXPECT_EQ(test::run({"ask", map, "kitchen"}).exitCode, 0);
  const auto predictions = readWorld(map).places.predictions;
  ASSERT_TRUE(predictions);
  EXPECT_TRUE(predictions->areByName);
}

}  // namespace
}  // namespace estancia::test
