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
  /// Trains on the clouds and their words.
  CommandResult trainWords(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{clouds(), "--recorded-labels", words(), "--study", study(), "-o", model()};
    all.insert(all.end(), more.begin(), more.end());
    return train(all);
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
  const CommandResult taught = train({clouds(), "--truth", "-o", model(), "--overwrite", "--json"});
  ASSERT_EQ(taught.exitCode, 0) << taught.err;
  const auto known = nlohmann::json::parse(taught.out);
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
                                               {"--recorded-labels", words()}}) {
    std::vector<std::string> withTruth{clouds(), "--truth", "-o", model()};
    withTruth.insert(withTruth.end(), more.begin(), more.end());
    refuses(train(withTruth), ErrorCode::invalidOption);
  }
  refuses(train({clouds(), "--truth", "-o", ""}), ErrorCode::invalidOption);
  refuses(train({clouds(), "--study", study(), "-o", model()}), ErrorCode::fileNotFound);
  refuses(trainWords({"--min-coverage", "0.5"}), ErrorCode::insufficientData);
  writeFile(words(), "image,coffee mug,pop bottle\nthing-1,1,0\n");
  refuses(trainWords(), ErrorCode::insufficientData);
}

}  // namespace
}  // namespace estancia::test
