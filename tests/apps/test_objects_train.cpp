// `estancia objects train` on clouds that a recording has words for.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

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
  static CommandResult train(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"objects", "train"});
    arguments.insert(arguments.end(), {"--classifier", "svm-linear"});
    return run(arguments);
  }
  /// Of the clouds and what is said of them.
  CommandResult trainWords(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{clouds(), "--recorded-labels", words(), "--study", study(), "-o", model()};
    all.insert(all.end(), more.begin(), more.end());
    return train(all);
  }
  template <class... Facts>
  void refuses(const CommandResult& result, ErrorCode code, Facts&&... facts) const {
    EXPECT_THAT(result, FailsWith(code, std::forward<Facts>(facts)...));
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
}

TEST_F(ObjectsTrain, ViewsThatAreGivenTwiceAreRefused) {
  fs::create_directory_symlink(clouds(), scratch_ / "link");
  for (const std::string& again : {clouds(), clouds() + "/", std::string(scratch_ / "link")})
    refuses(train({clouds(), again, "--truth", "-o", model()}), ErrorCode::invalidOption, again);
}

TEST_F(ObjectsTrain, OptionsWithoutMeaningAreRefused) {
  const auto withTruth = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {clouds(), "--truth", "-o", model()});
    return train(more);
  };
  refuses(withTruth({"--pseudo-labels", "top"}), ErrorCode::invalidOption, "--pseudo-labels");
  refuses(withTruth({"--no-correct-prior"}), ErrorCode::invalidOption, "--no-correct-prior");
  refuses(withTruth({"--min-coverage", "0.5"}), ErrorCode::invalidOption, "--min-coverage");
  refuses(withTruth({"--recorded-labels", words()}), ErrorCode::invalidOption, "--recorded-labels");
  refuses(trainWords({"--split", "tset"}), ErrorCode::unknownName, "tset");
  refuses(train({clouds(), "--truth", "-o", ""}), ErrorCode::invalidOption, "-o");
}

TEST_F(ObjectsTrain, ParametersReachTheClassifierAndTheShapes) {
  const auto choice = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--json", "--overwrite"});
    const CommandResult trained = trainWords(more);
    EXPECT_EQ(trained.exitCode, 0) << trained.err;
    return nlohmann::json::parse(trained.out, nullptr, false)["choice"].get<std::string>();
  };
  EXPECT_EQ(choice({"--set", "training.classifier.c=7"}).find("C 7"), 0U);
  writeFile(scratch_ / "p.toml", "[training.classifier]\nc = 3\n[training.shape]\nsamples = 100\n");
  EXPECT_EQ(choice({"--config", scratch_ / "p.toml"}).find("C 3"), 0U);
  const std::string few = readFile(model());
  choice({"--config", scratch_ / "p.toml", "--set", "training.shape.samples=200"});
  EXPECT_NE(readFile(model()), few);
  EXPECT_THAT(trainWords({"--overwrite", "--set", "training.shape.samples=0"}),
              FailsWith(ErrorCode::invalidOption, "samples"));
  EXPECT_THAT(trainWords({"--overwrite", "--set", "training.size=true"}),
              FailsWith(ErrorCode::unknownName, "size"));
}

TEST_F(ObjectsTrain, ViewsNeedTheirLabels) {
  refuses(train({clouds(), "--study", study(), "-o", model()}), ErrorCode::fileNotFound, clouds(),
          "--recorded-labels");
  writeFile(words(), "image,coffee mug,pop bottle\nthing-1,1,0\n");
  refuses(trainWords(), ErrorCode::insufficientData, "\"thing-1\"");
}

TEST_F(ObjectsTrain, WarnsOfLabelsThatTheLabelerHasNot) {
  writeFile(study(),
            "[classes.mug]\nlabels = [\"coffee mug\", \"cofee mug\"]\n[classes.bottle]\nlabels = [\"pop "
            "bottle\"]\n");
  const CommandResult trained = trainWords();
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.err, HasSubstr("\"cofee mug\""));
}

TEST_F(ObjectsTrain, ClassesInAPersonsWordsGetTheLabelsThatAreKindsOfThem) {
  const std::string mug = "[classes.mug]\nlabels = [\"coffee mug\"]\n";
  writeFile(study(), mug + "[classes.bottle]\nlabels = [\"container\"]\n");
  const CommandResult trained = trainWords();
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.err,
              HasSubstr("bottle: the labeler has no label of that name; taken: pop bottle (a kind "
                        "of container)"));
  EXPECT_THAT(readFile(model()), HasSubstr("pop bottle")) << "for machines without WordNet";
  fs::remove(model());
  writeFile(study(), mug + "[classes.bottle]\nlabels = [\"soda\"]\n");
  refuses(trainWords(), ErrorCode::unknownName, "bottle (is it", "pop bottle");
  const WithoutWordNet plain;
  writeFile(study(), mug + "[classes.bottle]\nlabels = [\"container\"]\n");
  refuses(trainWords(), ErrorCode::unknownName, "bottle;");
}

TEST_F(ObjectsTrain, ViewsOfNoClassAreAnError) {
  refuses(trainWords({"--min-coverage", "0.5"}), ErrorCode::insufficientData, "\"wall\"");
}

}  // namespace
}  // namespace estancia::test
