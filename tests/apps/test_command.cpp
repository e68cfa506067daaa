// The command as a user runs it, on small images and a network that knows four colors.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "apps/json_of.hpp"
#include "estancia/map_file/store.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace fs = std::filesystem;

const std::vector<cv::Scalar> colors{{20, 20, 230}, {20, 230, 20}, {230, 20, 20}, {230, 230, 230}};

class Command : public testing::Test {
 protected:
  void SetUp() override { writeSmallModel(model_); }

  /// `stay` images of each color in turn.
  void writeImages(const fs::path& folder, std::size_t stay = 10, std::size_t visits = 4) {
    fs::create_directories(folder);
    cv::RNG random(3);
    for (std::size_t i = 0; i < stay * visits; ++i) {
      cv::Mat image(48, 64, CV_8UC3, colors[i / stay % colors.size()]);
      cv::Mat noise(image.size(), CV_8SC3);
      random.fill(noise, cv::RNG::NORMAL, 0, 4);
      cv::add(image, noise, image, {}, CV_8UC3);
      cv::imwrite((folder / ("frame" + std::to_string(i) + ".jpg")).string(), image);
    }
  }

  CommandResult map(const fs::path& sequence, const fs::path& file,
                    const std::vector<std::string>& more = {}) {
    return run({"map", sequence, "-o", file, "--model", model_, "--distance", "l2"}, more);
  }

  static void expectError(const CommandResult& result, ErrorCode code) {
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_EQ(result.out, "");
  }

  /// Changes a map as a hostile program might.
  static void tamper(const fs::path& path, const std::string& sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    sqlite3_close(database);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string model_ = scratch_ / "model";
  const std::string images_ = scratch_ / "images";
  const std::string map_ = scratch_ / "home.estancia";
};

TEST_F(Command, EveryHelpHasAnExample) {
  std::istringstream names(
      "label,map,ask,route,localize,evaluate,explain,export,report,experiment,models,cache,classify,"
      "classify train,classify test,classify predict,classify show,classify name,objects collect,"
      "objects label,objects train,objects predict");
  for (std::string name; std::getline(names, name, ',');) {
    std::vector<std::string> words;
    std::istringstream in(name);
    for (std::string word; in >> word;) words.push_back(word);
    words.emplace_back("--help");
    const auto result = run(words);
    EXPECT_EQ(result.exitCode, 0) << name;
    EXPECT_NE(result.out.find("  estancia " + name), std::string::npos) << name;
  }
  EXPECT_EQ(run({"--help"}).exitCode, 0);
  EXPECT_EQ(run({"--version"}).exitCode, 0);
}

TEST_F(Command, WrongWordsAreOneLineAndExitCodeTwo) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"mapp"}, {"models", "lst"}, {"models", "check"}, {"map", "nowhere"}})
    expectError(run(words), ErrorCode::invalidOption);
}

TEST_F(Command, MapsAsksAndRoutes) {
  writeImages(images_);
  const json summary = jsonOf(map(images_, map_, {"--json"}));
  EXPECT_EQ(summary["frames"], 40);
  EXPECT_EQ(summary["nodes"], 4);
  EXPECT_EQ(summary["transitions"], 3);

  const auto asked = run({"ask", map_, "WORD 2", "--json"});
  EXPECT_EQ(asked.exitCode, 0) << asked.err;
  EXPECT_EQ(json::parse(asked.out)["places"].size(), 4U);
  const int best = json::parse(asked.out)["places"][0]["node"];
  const auto route = run({"route", map_, "--from", "0", "--to", "word 2", "--tolerance", "0", "--json"});
  EXPECT_EQ(json::parse(route.out)["to"], best) << route.err;
  const auto direct = run({"route", map_, "--from", "0", "--to", "3", "--json"});
  EXPECT_EQ(json::parse(direct.out)["nodes"], json({0, 1, 2, 3})) << direct.err;
  EXPECT_EQ(json::parse(run({"explain", map_, "frame10.jpg", "--json"}).out)["decision"], "create-node");
  expectError(run({"route", map_, "--from", "0", "--to", "99"}), ErrorCode::unknownName);
}

TEST_F(Command, NoWayIsAnAnswerOfItsOwn) {
  writeImages(images_);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const WithoutWordNet plain;
  for (const std::vector<std::string>& to : {std::vector<std::string>{"0", "--one-way"}, {"wrod 2"}}) {
    std::vector<std::string> arguments{"route", map_, "--from", "3", "--to"};
    arguments.insert(arguments.end(), to.begin(), to.end());
    EXPECT_EQ(run(arguments).exitCode, 1);
    arguments.push_back("--json");
    const auto printed = run(arguments);
    EXPECT_EQ(printed.exitCode, 1) << printed.err;
    EXPECT_TRUE(json::parse(printed.out)["to"].is_null());
  }
}

TEST_F(Command, OverwritesMapsOnlyAndWhenThereIsANewOne) {
  writeImages(images_, 3, 2);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const std::string before = readFile(map_);
  writeFile(scratch_ / "text/a.jpg", "this is no image");
  expectError(map(scratch_ / "text", map_, {"--overwrite"}), ErrorCode::fileUnreadable);
  EXPECT_EQ(readFile(map_), before);
  EXPECT_EQ(map(images_, map_, {"--overwrite"}).exitCode, 0);
  const std::string letter = scratch_ / "letter.txt";
  writeFile(letter, "dear reader");
  expectError(map(images_, letter, {"--overwrite"}), ErrorCode::unsupportedFile);
  EXPECT_EQ(readFile(letter), "dear reader");
  const std::string folder = scratch_ / "folder";
  fs::create_directory(folder);
  for (const std::vector<std::string>& how : {std::vector<std::string>{"--overwrite"}, {}})
    expectError(map(images_, folder, how), ErrorCode::fileUnwritable);
  EXPECT_TRUE(fs::is_directory(folder));
}

TEST_F(Command, SaysWhenItsOutputIsLost) {
  writeImages(images_, 3, 2);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const std::string line =
      std::string(ESTANCIA_COMMAND) + " ask '" + map_ + "' 'word 1' >/dev/full 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 2);
}

TEST_F(Command, LocalizesWithOneLineOfJsonAFrame) {
  writeImages(images_);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const auto lines =
      jsonLinesOf(run({"localize", map_, images_, "--model", model_, "--json", "--lookahead", "3"}));
  ASSERT_EQ(lines.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    const json& at = lines[i];
    const std::string image = "frame" + std::to_string(i) + ".jpg";
    EXPECT_EQ(at["image"], image);
    EXPECT_EQ(at["nearest_image"], image);
    EXPECT_EQ(at["node"], i / 10);
    for (const char* key : {"distance", "belief_node", "belief_image", "confidence"})
      EXPECT_TRUE(at.contains(key));
  }
}

TEST_F(Command, EvaluatesAgainstRooms) {
  writeImages(images_);
  std::string rooms = "image,room\n";
  for (int i = 0; i < 40; ++i)
    rooms += "frame" + std::to_string(i) + ".jpg,room " + std::to_string(i / 10) + "\n";
  writeFile(fs::path(images_) / "rooms.csv", rooms);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const json measures = json::parse(run({"evaluate", map_, "--json"}).out);
  EXPECT_DOUBLE_EQ(measures["v_measure"], 1);
  EXPECT_DOUBLE_EQ(measures["purity"], 1);
  EXPECT_TRUE(measures["spatial_spread"].is_null());
  std::string truth = "query,refs\n";
  for (int i = 0; i < 40; ++i) truth += std::to_string(i) + "," + std::to_string(i) + "\n";
  writeFile(scratch_ / "truth.csv", truth);
  const json found = json::parse(
      run({"evaluate", map_, images_, "--model", model_, "--truth", scratch_ / "truth.csv", "--json"}).out);
  EXPECT_DOUBLE_EQ(found["recall"], 1);
  EXPECT_DOUBLE_EQ(found["image_room"], 1);
  writeFile(scratch_ / "truth.csv", "query,refs\n0,x\n");
  expectError(run({"evaluate", map_, images_, "--model", model_, "--truth", scratch_ / "truth.csv"}),
              ErrorCode::malformedFile);
}

TEST_F(Command, ExplainsExportsAndReports) {
  writeImages(images_);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const json explained = json::parse(run({"explain", map_, "10", "--json"}).out);
  EXPECT_EQ(explained["decision"], "create-node");
  EXPECT_GT(explained["to_current"], explained["tau_join"]);
  const std::vector<std::string> exporting{"export", map_, "--format", "json"};
  EXPECT_EQ(json::parse(run(exporting).out)["places"].size(), 4U);
  expectError(run({"export", map_, "--format", "nav2"}), ErrorCode::insufficientData);
  const std::string photo = images_ + "/frame10.jpg", before = readFile(photo);
  std::vector<std::string> replacing = exporting;
  replacing.insert(replacing.end(), {"--overwrite", "-o", photo});
  expectError(run(replacing), ErrorCode::fileExists);
  EXPECT_EQ(readFile(photo), before);
  writeFile(scratch_ / "empty.json", "");
  replacing.back() = scratch_ / "empty.json";
  EXPECT_EQ(run(replacing).exitCode, 0);
  std::vector<std::string> page{"report", map_, "-o", scratch_ / "page.html", "--label", "word 1"};
  const auto report = run(page);
  EXPECT_EQ(report.exitCode, 0) << report.err;
  expectError(run(page), ErrorCode::fileExists);
  page.insert(page.end(), {"--overwrite", "--json"});
  const auto again = run(page);
  EXPECT_EQ(json::parse(again.out)["shows"], "map") << again.err;
}

TEST_F(Command, SkipsATruncatedImageUnlessStrict) {
  writeImages(images_, 25);
  const fs::path broken = fs::path(images_) / "frame50.jpg";
  writeFile(broken, readFile(broken).substr(0, 600));
  const auto lenient = map(images_, map_, {"--json"});
  EXPECT_EQ(lenient.exitCode, 0) << lenient.err;
  EXPECT_EQ(json::parse(lenient.out)["frames"], 99);
  EXPECT_EQ(json::parse(lenient.out)["skipped"], 1);
  expectError(map(images_, scratch_ / "strict.estancia", {"--strict"}), ErrorCode::truncatedFile);
}

TEST_F(Command, ContinuesAnExistingMapOnlyWhenTold) {
  writeImages(images_);
  const fs::path half = scratch_ / "half";
  fs::create_directories(half);
  for (int i = 0; i < 23; ++i) {
    const std::string name = "frame" + std::to_string(i) + ".jpg";
    fs::copy_file(fs::path(images_) / name, half / name);
  }
  ASSERT_EQ(map(half, map_).exitCode, 0);
  expectError(map(images_, map_), ErrorCode::fileExists);
  EXPECT_EQ(jsonOf(map(images_, map_, {"--continue", "--json"}))["new_frames"], 17);
  ASSERT_EQ(map(images_, scratch_ / "whole.estancia").exitCode, 0);
  EXPECT_EQ(run({"export", map_, "--format", "json"}).out,
            run({"export", scratch_ / "whole.estancia", "--format", "json"}).out);
  const auto nothing = map(images_, map_, {"--continue", "--json"});
  EXPECT_EQ(json::parse(nothing.out)["new_frames"], 0) << nothing.err;
  writeImages(scratch_ / "other", 2, 2);
  fs::rename(scratch_ / "other/frame0.jpg", scratch_ / "other/elsewhere.jpg");
  const auto another = map(scratch_ / "other", map_, {"--continue", "--json"});
  EXPECT_EQ(json::parse(another.out)["new_frames"], 4) << another.err;
  const json drives = json::parse(run({"drives", map_, "--json"}).out)["drives"];
  ASSERT_EQ(drives.size(), 2U);
  EXPECT_EQ(drives[1]["name"], "other");
  EXPECT_EQ(drives[1]["frames"], 4);
}

TEST_F(Command, ShowsNoControlCharactersOfAMapFile) {
  writeImages(images_, 5);
  ASSERT_EQ(map(images_, map_).exitCode, 0);
  const std::string named = scratch_ / "named.estancia", home = scratch_ / "home";
  fs::copy_file(map_, named);
  // ESC, BEL, the C1 control CSI, and what turns the writing round.
  const std::string controls = "\x1B[2J\x07\u009B\u202E", inSql = "'[2J' || char(27, 7, 155, 8238)";
  tamper(named, "UPDATE frames SET name = name || " + inSql);
  std::vector<std::string> labels;
  for (int i = 0; i < 4; ++i) labels.push_back("word " + std::to_string(i) + controls);
  {
    MapStore store = MapStore::open(map_, MapStore::Access::write);
    DescriptorMatrix rooms(2);
    for (int i = 0; i < 20; ++i) rooms.append(std::vector<float>{0.75F, 0.25F});
    store.putPredictions({"svm" + controls, {"hall" + controls, "bath" + controls}, rooms});
    store.commit();
  }
  tamper(map_, "UPDATE frames SET name = name || " + inSql + ", room = 'kitchen' || " + inSql +
                   "; UPDATE meta SET value = value || " + inSql + " WHERE key = 'model'");
  for (int i = 0; i < 4; ++i)
    tamper(map_, "UPDATE labels SET label = '" + labels[i] + "' WHERE id = " + std::to_string(i));
  tamper(map_, "UPDATE meta SET value = '" + Vocabulary(labels).digest() + "' WHERE key = 'vocabulary'");

  const std::string zones = scratch_ / "home.zones", rooms = scratch_ / "rooms.classifier";
  const std::vector<std::vector<std::string>> commands{
      {"ask", map_, "word 1"},
      {"explain", map_, "0"},
      {"explain", map_, "none"},
      {"route", map_, "--from", "0", "--to", "word 1"},
      {"evaluate", map_},
      {"export", map_, "--format", "json"},
      {"zones", "find", map_, "-o", zones},
      {"classify", "train", map_, "-o", rooms, "--classifier", "knn"},
      {"classify", "test", rooms, map_},
      {"classify", "name", rooms, map_},
      {"localize", map_, images_, "--model", model_},
      {"map", images_, "-o", map_, "--model", model_, "--continue"},
      {"map", images_, "-o", named, "--model", model_, "--continue"},
      {"drives", named},
      {"explain", named, "0"}};
  for (const auto& arguments : commands) {
    const auto result = run(arguments);
    const std::string shown = result.out + result.err;
    EXPECT_NE(shown, "") << arguments[0];
    for (const char* control : {"\x1B", "\x07", "\u009B", "\u202E"})
      EXPECT_THAT(shown, testing::Not(HasSubstr(control))) << testing::PrintToString(arguments);
  }
  EXPECT_THAT(run({"ask", map_, "word 1"}).out, HasSubstr("(kitchen[2J\\x1B\\x07\\xC2\\x9B\\xE2\\x80\\xAE"));
}

TEST_F(Command, ListsAddsAndChecksModels) {
  const std::string home = scratch_ / "home";
  const char* before = std::getenv("ESTANCIA_HOME");
  const std::string saved = before != nullptr ? before : "";
  setenv("ESTANCIA_HOME", home.c_str(), 1);
  EXPECT_EQ(run({"models", "list", "--json"}).out, "");
  const auto added = run({"models", "add", model_});
  EXPECT_EQ(added.exitCode, 0) << added.err;
  expectError(run({"models", "add", model_}), ErrorCode::fileExists);
  EXPECT_EQ(run({"models", "add", model_, "--overwrite"}).exitCode, 0);
  const auto listed = run({"models", "list", "--json"});
  const std::string name = json::parse(listed.out)["name"];
  EXPECT_EQ(json::parse(run({"models", "check", name, "--json"}).out)["labels"], 4);
  expectError(run({"models", "check", "alexnet"}), ErrorCode::unknownName);
  if (before != nullptr)
    setenv("ESTANCIA_HOME", saved.c_str(), 1);
  else
    unsetenv("ESTANCIA_HOME");
}

}  // namespace
}  // namespace estancia::test
