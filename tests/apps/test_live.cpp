// estancia live: recordings that are played, runs that are killed or interrupted, wrong arguments.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
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

/// A command that an agent started, and talks to on its standard input and output, a message a line.
class Agent {
 public:
  explicit Agent(std::vector<std::string> words) {
    words.insert(words.begin(), ESTANCIA_COMMAND);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::array<int, 2> in{}, out{};
    if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) return;
    child_ = fork();
    if (child_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      execv(ESTANCIA_COMMAND, arguments.data());
      _exit(127);
    }
    close(in[0]), close(out[1]);
    to_ = in[1], from_ = out[0];
  }
  ~Agent() {
    if (child_ > 0) kill(child_, SIGKILL);
    leave();
  }
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// The result of a request; null where no answer comes, or one to something else.
  Json ask(const std::string& method, const Json& params = Json::object()) {
    const int id = ++asked_;
    tell({{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}});
    const Json answer = Json::parse(readLine(), nullptr, false);
    return answer.is_object() && answer.value("id", 0) == id && answer.contains("result") ? answer["result"]
                                                                                          : Json();
  }
  void tell(const Json& message) {
    const std::string line = message.dump() + "\n";
    EXPECT_EQ(write(to_, line.data(), line.size()), static_cast<ssize_t>(line.size()));
  }
  /// Closes its standard input. Returns its exit code, -1 where it was ended by a signal.
  int leave() {
    if (child_ <= 0) return code_;
    close(to_);
    while (receive()) {
    }
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    close(from_);
    return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// What nobody asked for.
  const std::string& unread() const { return buffer_; }

 private:
  std::string readLine() {
    std::size_t end = 0;
    while ((end = buffer_.find('\n')) == std::string::npos)
      if (!receive()) return "";
    std::string line = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return line;
  }
  /// False at the end, and when nothing comes for a minute.
  bool receive() {
    pollfd ready{from_, POLLIN, 0};
    std::array<char, 4096> part{};
    if (poll(&ready, 1, 60000) <= 0) return false;
    const ssize_t got = read(from_, part.data(), part.size());
    if (got > 0) buffer_.append(part.data(), static_cast<std::size_t>(got));
    return got > 0;
  }

  pid_t child_ = -1;
  int to_ = -1, from_ = -1, code_ = -1, asked_ = 0;
  std::string buffer_;
};

TEST_F(LiveCommand, AnAgentAsksWhereItIsWhileItRuns) {
  std::vector<std::string> words = command("0.5");
  words.push_back("--mcp");
  Agent agent(words);
  const Json hello = agent.ask("initialize", {{"protocolVersion", "2025-06-18"},
                                              {"capabilities", Json::object()},
                                              {"clientInfo", {{"name", "test"}, {"version", "1"}}}});
  ASSERT_TRUE(hello.is_object());
  EXPECT_EQ(hello["protocolVersion"], "2025-06-18");
  agent.tell({{"jsonrpc", "2.0"}, {"method", "notifications/initialized"}});
  std::vector<std::string> tools;
  const Json listed = agent.ask("tools/list");
  ASSERT_TRUE(listed.is_object());
  for (const Json& tool : listed["tools"]) tools.push_back(tool["name"]);
  EXPECT_THAT(tools, testing::Contains("where_am_i"));
  const auto whereAmI = [&agent] { return agent.ask("tools/call", {{"name", "where_am_i"}}); };
  Json where = whereAmI();
  const auto isPlaced = [&where] {
    return where.is_object() && !where["structuredContent"]["place"].is_null();
  };
  for (int i = 0; i < 600 && where.is_object() && !isPlaced(); ++i, where = whereAmI())  // its first frame
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_TRUE(isPlaced()) << where;
  EXPECT_EQ(where["isError"], false);
  EXPECT_EQ(where["structuredContent"]["state"], "mapping") << "it runs";
  EXPECT_GE(where["structuredContent"]["place"]["node"], 0);
  const int frame = std::stoi(where["structuredContent"]["frame"].get<std::string>());
  EXPECT_GE(frame, 1000);
  EXPECT_LT(frame, 1000 + frames);
  EXPECT_THAT(where["content"][0]["text"].get<std::string>(), HasSubstr("place"));

  EXPECT_EQ(agent.leave(), 0) << "an agent that goes ends the run";
  EXPECT_EQ(agent.unread(), "") << "standard output is the agent's alone";
  const TopologicalMap map = readMap(map_);
  EXPECT_GT(map.frames.size(), 0U);
  EXPECT_LT(map.frames.size(), static_cast<std::size_t>(frames));
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

TEST_F(LiveCommand, FailsWhereNothingCouldBeMapped) {
  for (const auto& entry : fs::directory_iterator(scratch_ / "images")) std::ofstream(entry.path()) << "text";
  const CommandResult run = test::run(command("0"));
  EXPECT_EQ(run.exitCode, 2);
  EXPECT_THAT(run.err, HasSubstr("no image of"));
  EXPECT_THAT(run.err, HasSubstr("not an image"));
  EXPECT_FALSE(fs::exists(map_));
}

TEST_F(LiveCommand, AMapThatIsNoneIsToldOfAsSuch) {
  std::ofstream(scratch_ / "bad.estancia") << "no map";
  for (const auto& [name, why] :
       {std::pair{"bad.estancia", "too short for a map"}, {"none.estancia", "no such map"}}) {
    const CommandResult run = test::run({"live", scratch_ / name});
    EXPECT_EQ(run.exitCode, 2);
    EXPECT_THAT(run.err, HasSubstr(why));
  }
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
