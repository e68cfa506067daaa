// `estancia objects train` on clouds that a recording has words for.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/io/cloud_file.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
    std::vector<std::string> all{clouds(), "--labels", words(), "--study", study(), "-o", model()};
    all.insert(all.end(), more.begin(), more.end());
    return train(all);
  }
  void refuses(const CommandResult& result, const std::string& why) const {
    EXPECT_EQ(result.exitCode, 2) << result.out;
    EXPECT_THAT(result.err, HasSubstr(why));
    EXPECT_FALSE(fs::exists(model()));
  }

  ScratchFolder scratch_;
};

TEST_F(ObjectsTrain, LearnsWhatARecordingSaysOfClouds) {
  const CommandResult trained = trainWords({"--json"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.err, Not(HasSubstr("warning")));
  const auto learned = nlohmann::json::parse(trained.out);
  EXPECT_EQ(learned["words"][0]["views"], 4);
  EXPECT_EQ(learned["words"][1]["instances"], 4);
  EXPECT_EQ(learned["pseudo_label_accuracy"], 1);
}

TEST_F(ObjectsTrain, ViewsThatAreGivenTwiceAreRefused) {
  fs::create_directory_symlink(clouds(), scratch_ / "link");
  for (const std::string& again : {clouds(), clouds() + "/", std::string(scratch_ / "link")})
    refuses(train({clouds(), again, "--truth", "-o", model()}), "are the same views");
}

TEST_F(ObjectsTrain, OptionsThatWouldMeanNothingAreRefused) {
  for (const auto& [option, value] :
       {std::pair("--names", "top"), std::pair("--prior", "none"), std::pair("--min-coverage", "0.5")})
    refuses(train({clouds(), "--truth", option, value, "-o", model()}), option);
  refuses(trainWords({"--split", "tset"}), "have no splits");
  refuses(train({clouds(), "--truth", "-o", ""}), "has no name");
}

TEST_F(ObjectsTrain, TellsHowToGetWords) {
  refuses(train({clouds(), "--study", study(), "-o", model()}),
          "estancia objects label " + clouds() + " -o NAME.labels`, then give --labels NAME.labels");
  writeFile(words(), "image,coffee mug,pop bottle\nthing-1,1,0\n");
  refuses(trainWords(), "\"thing-1\"");
}

TEST_F(ObjectsTrain, WarnsOfLabelsThatTheLabelerHasNot) {
  writeFile(study(),
            "[classes.mug]\nlabels = [\"coffee mug\", \"cofee mug\"]\n[classes.bottle]\nlabels = [\"pop "
            "bottle\"]\n");
  const CommandResult trained = trainWords();
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  EXPECT_THAT(trained.err, AllOf(HasSubstr("warning"), HasSubstr("\"cofee mug\" (is it coffee mug?)")));
}

TEST_F(ObjectsTrain, WhereNothingIsNamedItSaysWhatToDo) {
  refuses(trainWords({"--min-coverage", "0.5"}), "mostly \"wall\"");
}

}  // namespace
}  // namespace estancia::test
