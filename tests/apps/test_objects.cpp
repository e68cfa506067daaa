// `estancia objects` as a user runs it, from a sequence to what its things are.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::SizeIs;

const cv::Vec3b red{0, 0, 255}, blue{255, 0, 0};

const char* const study = R"(
[classes.ball]
labels = ["word 0"]
[classes.box]
labels = ["word 1"]
)";

std::vector<Solid> things() {
  return {ballAt(0.2, 0.2, 0.05, red),
          ballAt(0.0, 0.2, 0.06, red),
          ballAt(-0.2, 0.2, 0.07, red),
          boxAt(0.2, -0.15, {0.05, 0.04, 0.06}, blue),
          boxAt(0.0, -0.15, {0.04, 0.06, 0.05}, blue),
          boxAt(-0.2, -0.15, {0.05, 0.05, 0.07}, blue)};
}

class Objects : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ESTANCIA_CACHE", (scratch_ / "cache").c_str(), 1);
    TableSequence(things(), {0, 15, 30, 45}).writeTo(scratch_ / "table");
    writeColorModel(scratch_ / "colors");
    writeFile(scratch_ / "study.toml", study);
  }
  void TearDown() override { unsetenv("ESTANCIA_CACHE"); }
  CommandResult objects(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "objects");
    return run(arguments);
  }
  CommandResult collect(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"collect", scratch_ / "table", "-o", scratch_ / "things"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  CommandResult label(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"label", scratch_ / "things", "--model", scratch_ / "colors"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  CommandResult train(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{
        "train",        scratch_ / "things", "--study",    scratch_ / "study.toml", "-o", model(),
        "--classifier", "svm-linear",        "--all-views"};
    all.insert(all.end(), more.begin(), more.end());
    return objects(all);
  }
  std::string model() const { return scratch_ / "table.objects"; }

  ScratchFolder scratch_;
};

std::vector<json> lines(const std::string& text) {
  std::vector<json> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(json::parse(line));
  return all;
}

TEST_F(Objects, CollectsLabelsAndLearnsShapes) {
  const CommandResult collected = collect({"--json"});
  ASSERT_EQ(collected.exitCode, 0) << collected.err;
  const json counts = json::parse(collected.out);
  EXPECT_EQ(counts["frames"], 4);
  EXPECT_EQ(counts["instances"], 6);
  EXPECT_EQ(counts["views"], 24);
  EXPECT_EQ(counts["unread"], 0);

  const CommandResult labeled = label({"--json"});
  ASSERT_EQ(labeled.exitCode, 0) << labeled.err;
  EXPECT_EQ(json::parse(labeled.out)["views"], 24);
  EXPECT_EQ(json::parse(labeled.out)["words"], 4) << "all answers are kept";
  const auto remembered = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--json", "--overwrite"});
    const CommandResult again = label(more);
    EXPECT_EQ(again.exitCode, 0) << again.err;
    return json::parse(again.out)["remembered"];
  };
  EXPECT_EQ(remembered({"--margin", "0.3", "--background", "gray"}), 0) << "other images";
  EXPECT_EQ(remembered({}), 24) << "images that were labeled before";

  const CommandResult trained = train({"--json"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const json learned = json::parse(trained.out);
  ASSERT_THAT(learned["classes"], SizeIs(2));
  for (const json& entry : learned["classes"]) {
    EXPECT_EQ(entry["instances"], 3) << entry;
    EXPECT_EQ(entry["views"], 12);
    EXPECT_GT(entry["held_out_accuracy"], 0.8);
    EXPECT_NEAR(entry["prior"], 0.5, 0.2);
  }
  EXPECT_EQ(learned["pseudo_labels"], "voted");
  EXPECT_EQ(learned["pseudo_label_accuracy"], nullptr) << "no category is known";
}

TEST_F(Objects, PredictsByImageAndInTheDarkByShape) {
  ASSERT_EQ(collect().exitCode, 0);
  ASSERT_EQ(label().exitCode, 0);
  ASSERT_EQ(train().exitCode, 0);
  TableSequence other({ballAt(0.1, 0.15, 0.055, red), boxAt(0, -0.1, {0.05, 0.05, 0.06}, blue)}, {70, 80});
  other.writeTo(scratch_ / "other");
  other.dim(0.03);
  other.writeTo(scratch_ / "dark");
  for (const bool dark : {false, true}) {
    const CommandResult predicted =
        objects({"predict", scratch_ / (dark ? "dark" : "other"), "--object-model", model(), "--model",
                 scratch_ / "colors", "--json", "--render", scratch_ / (dark ? "dark.png" : "other.png")});
    ASSERT_EQ(predicted.exitCode, 0) << predicted.err;
    const auto frames = lines(predicted.out);
    ASSERT_THAT(frames, SizeIs(2));
    std::set<std::string> classes;
    for (const json& object : frames[1]["objects"]) {
      EXPECT_EQ(object["views"], 2);
      EXPECT_EQ(object["answer"]["source"], dark ? "shape" : "both") << object;
      EXPECT_THAT(object["box"], SizeIs(4));
      classes.insert(object["answer"]["class"]);
    }
    EXPECT_EQ(classes, (std::set<std::string>{"ball", "box"}));
  }
  EXPECT_EQ(cv::imread(scratch_ / "other.png").size(), cv::Size(320, 240));
  const CommandResult some = objects({"predict", scratch_ / "table", "--object-model", model(), "--json",
                                      "--shape-only", "--first", "1", "--every", "2", "--max-frames", "1"});
  EXPECT_THAT(lines(some.out), SizeIs(1)) << some.err;
}

TEST_F(Objects, ReplacesOnlyWithOverwrite) {
  writeFile(scratch_ / "things/notes.txt", "mine");
  EXPECT_THAT(collect(), FailsWith(ErrorCode::fileExists));
  EXPECT_THAT(collect({"--overwrite"}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(scratch_ / "things/notes.txt"), "mine");
  fs::remove_all(scratch_ / "things");
  ASSERT_EQ(collect().exitCode, 0);
  EXPECT_EQ(collect({"--overwrite", "--max-frames", "1"}).exitCode, 0);
  ASSERT_EQ(label().exitCode, 0);
  EXPECT_THAT(label(), FailsWith(ErrorCode::fileExists));
  EXPECT_THAT(collect({"--overwrite", "--first", "17"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_TRUE(fs::exists(scratch_ / "things/words.labels")) << "nothing is lost by a wrong option";

  writeFile(model(), "mine");
  EXPECT_THAT(train({"--overwrite"}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(model()), "mine");
}

TEST_F(Objects, RefusesWhatItCannotUse) {
  const std::string samples = scratch_ / "things", table = scratch_ / "table", none = scratch_ / "none";
  ASSERT_EQ(collect().exitCode, 0);
  EXPECT_THAT(train(), FailsWith(ErrorCode::fileNotFound)) << "no labels";
  ASSERT_EQ(label().exitCode, 0);
  writeFile(model(), "no model");
  const auto by = [&](const std::string& study, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"train", samples, "-o", none, "--study", scratch_ / study});
    return more;
  };
  const std::vector<std::pair<std::vector<std::string>, ErrorCode>> refused{
      {{"collect", scratch_ / "table/rgb", "-o", none}, ErrorCode::invalidInput},
      {{"label", samples, "--model", scratch_ / "colors", "--margin", "0.7"}, ErrorCode::invalidOption},
      {{"label", table, "--model", scratch_ / "colors"}, ErrorCode::unsupportedFile},
      {{"train", samples, "-o", none}, ErrorCode::invalidOption},
      {by("study.toml", {"--recorded-labels", "a.labels", "--recorded-labels", "b.labels"}),
       ErrorCode::invalidOption},
      {{"predict", table, "--object-model", model()}, ErrorCode::unsupportedFile},
      {{"predict", table, "--object-model", model(), "--shape-only", "--margin", "0.2"},
       ErrorCode::invalidOption},
      {{"predict", table}, ErrorCode::invalidOption}};
  for (const auto& [arguments, code] : refused)
    EXPECT_THAT(objects(arguments), FailsWith(code)) << testing::PrintToString(arguments);
  fs::remove(scratch_ / "table/intrinsics.txt");
  EXPECT_THAT(objects({"collect", table, "-o", none}), FailsWith(ErrorCode::invalidInput)) << "no camera";
  EXPECT_FALSE(fs::exists(none));
  writeFile(scratch_ / "camera.txt", "262.5 262.5 159.5 119.5\n");
  EXPECT_EQ(collect({"--intrinsics", scratch_ / "camera.txt", "--overwrite"}).exitCode, 0);
}

}  // namespace
}  // namespace estancia::test
