// `estancia objects` as a user runs it, from a sequence or clouds to what its things are.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "apps/json_of.hpp"
#include "estancia/files/cloud_file.hpp"
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
  static CommandResult objects(const std::vector<std::string>& arguments) {
    return run({"objects"}, arguments);
  }
  CommandResult collect(const std::vector<std::string>& more = {}) const {
    return run({"objects", "collect", scratch_ / "table", "-o", scratch_ / "things"}, more);
  }
  CommandResult label(const std::vector<std::string>& more = {}) const {
    return run({"objects", "label", scratch_ / "things", "--model", scratch_ / "colors"}, more);
  }
  CommandResult train(const std::vector<std::string>& more = {}) const {
    return run({"objects", "train", scratch_ / "things", "--study", scratch_ / "study.toml", "-o", model(),
                "--classifier", "svm-linear", "--all-views"},
               more);
  }
  std::string model() const { return scratch_ / "table.objects"; }

  ScratchFolder scratch_;
};

TEST_F(Objects, CollectsLabelsAndLearnsShapes) {
  const json counts = jsonOf(collect({"--json"}));
  EXPECT_EQ(counts["frames"], 4);
  EXPECT_EQ(counts["instances"], 6);
  EXPECT_EQ(counts["views"], 24);
  EXPECT_EQ(counts["unread"], 0);

  const json labeled = jsonOf(label({"--json"}));
  EXPECT_EQ(labeled["views"], 24);
  EXPECT_EQ(labeled["words"], 4) << "all answers are kept";
  const auto remembered = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--json", "--overwrite"});
    return jsonOf(label(more))["remembered"];
  };
  EXPECT_EQ(remembered({"--margin", "0.3", "--background", "gray"}), 0) << "other images";
  EXPECT_EQ(remembered({}), 24) << "images that were labeled before";

  const json learned = jsonOf(train({"--json"}));
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

TEST_F(Objects, MakeTheirOwnClassesWithoutAStudy) {
  ASSERT_EQ(collect().exitCode, 0);
  ASSERT_EQ(label().exitCode, 0);
  const json learned = jsonOf(objects(
      {"train", scratch_ / "things", "-o", model(), "--classifier", "svm-linear", "--all-views", "--json"}));
  ASSERT_THAT(learned["classes"], SizeIs(2));
  for (const json& entry : learned["classes"]) {
    EXPECT_EQ(entry["instances"], 3) << entry;
    EXPECT_EQ(entry["labels"], json::array({entry["class"]}));
    EXPECT_EQ(entry["prior"], nullptr);
  }
  EXPECT_EQ(learned["own_classes"], json::parse(R"({"unsure": 0, "left_out": []})"));
  const auto frames = jsonLinesOf(objects({"predict", scratch_ / "table", "--object-model", model(),
                                           "--model", scratch_ / "colors", "--json", "--max-frames", "1"}));
  std::set<std::string> classes;
  for (const json& object : frames[0]["objects"]) classes.insert(object["answer"]["class"]);
  EXPECT_EQ(classes, (std::set<std::string>{"word 0", "word 1"}));
  EXPECT_EQ(jsonOf(run({"report", scratch_ / "things", "-o", scratch_ / "things.html", "--json"}))["shows"],
            "objects");
  EXPECT_THAT(run({"report", scratch_ / "things", "-o", scratch_ / "x.html", "--label", "mug"}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(Objects, CollectsEuclideanClustersWhereAskedTo) {
  fs::remove_all(scratch_ / "table");
  TableSequence({boxAt(0, 0, {0.05, 0.05, 0.05}, blue), boxAt(0.15, 0, {0.05, 0.05, 0.08}, red)}, {0})
      .writeTo(scratch_ / "table");
  EXPECT_EQ(jsonOf(collect({"--json", "--clusters", "euclidean"}))["instances"], 2);
  EXPECT_THAT(collect({"--overwrite", "--clusters", "square"}), FailsWith(ErrorCode::unknownName));
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
    const auto frames = jsonLinesOf(
        objects({"predict", scratch_ / (dark ? "dark" : "other"), "--object-model", model(), "--model",
                 scratch_ / "colors", "--json", "--render", scratch_ / (dark ? "dark.png" : "other.png")}));
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
  EXPECT_THAT(jsonLinesOf(some), SizeIs(1));
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
      {{"train", samples, "-o", none, "--min-coverage", "1"}, ErrorCode::insufficientData},
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

/// A lattice of points, `longer` in one direction.
PointCloud block(int longer) {
  PointCloud cloud;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y)
      for (int z = 0; z < 8; ++z)
        cloud.points.push_back(0.01 * cv::Point3f(cv::Point3i(x * longer, y, z + 100)));
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

class ObjectsTrain : public testing::Test {
 protected:
  void SetUp() override {
    std::string csv = "image,coffee mug,pop bottle,wall\n";
    for (int thing = 0; thing < 4; ++thing)
      for (const auto& [category, longer] : {std::pair("mug", 1), std::pair("bottle", 6)}) {
        const fs::path folder = scratch_ / "clouds" / category / fmt::format("{}_{}", category, thing);
        fs::create_directories(folder);
        const std::string name = fmt::format("{}_{}_0.pcd", category, thing);
        writeCloud(block(longer + thing % 2), folder / name);
        csv += name + (longer == 1 ? ",.1,0,.9\n" : ",0,.1,.9\n");
      }
    writeFile(words(), csv);
    writeFile(study(),
              "[classes.mug]\nlabels = [\"coffee mug\"]\n[classes.bottle]\nlabels = [\"pop bottle\"]\n");
  }
  std::string clouds() const { return scratch_ / "clouds"; }
  std::string words() const { return scratch_ / "words.csv"; }
  std::string study() const { return scratch_ / "study.toml"; }
  std::string model() const { return scratch_ / "some.objects"; }
  static CommandResult train(const std::vector<std::string>& arguments) {
    return run({"objects", "train", "--classifier", "svm-linear"}, arguments);
  }
  /// Trains on the clouds and their words.
  CommandResult trainWords(const std::vector<std::string>& more = {}) const {
    return run({"objects", "train", "--classifier", "svm-linear", clouds(), "--recorded-labels", words(),
                "--study", study(), "-o", model()},
               more);
  }
  void refuses(const CommandResult& result, ErrorCode code) const {
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_FALSE(fs::exists(model()));
  }

  ScratchFolder scratch_;
};

TEST_F(ObjectsTrain, LearnsWhatARecordingSaysOfClouds) {
  const CommandResult trained = trainWords({"--json"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_EQ(trained.err.find("warning"), std::string::npos) << trained.err;
  const auto learned = nlohmann::json::parse(trained.out);
  EXPECT_EQ(learned["classes"][0]["views"], 4);
  EXPECT_EQ(learned["classes"][1]["instances"], 4);
  EXPECT_EQ(learned["pseudo_label_accuracy"], 1);
  const auto known = jsonOf(train({clouds(), "--truth", "-o", model(), "--overwrite", "--json"}));
  EXPECT_EQ(known["pseudo_labels"], "true");
  EXPECT_EQ(known["classes"][0]["prior"], nullptr);
  EXPECT_EQ(known["classes"][1]["instances"], 4);
}

TEST_F(ObjectsTrain, RefusesWhatHasNoMeaning) {
  fs::create_directory_symlink(clouds(), scratch_ / "link");
  for (const std::string& again : {clouds(), clouds() + "/", std::string(scratch_ / "link")})
    refuses(train({clouds(), again, "--truth", "-o", model()}), ErrorCode::invalidOption);
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--pseudo-labels", "top"},
                                               {"--no-correct-prior"},
                                               {"--min-coverage", "0.5"},
                                               {"--recorded-labels", words()}})
    refuses(run({"objects", "train", clouds(), "--truth", "-o", model()}, more), ErrorCode::invalidOption);
  refuses(train({clouds(), "--truth", "-o", ""}), ErrorCode::invalidOption);
  refuses(train({clouds(), "--study", study(), "-o", model()}), ErrorCode::fileNotFound);
  refuses(trainWords({"--min-coverage", "0.5"}), ErrorCode::insufficientData);
  writeFile(words(), "image,coffee mug,pop bottle\nthing-1,1,0\n");
  refuses(trainWords(), ErrorCode::insufficientData);
}

}  // namespace
}  // namespace estancia::test
