// The things of a furnished home, rendered with their true masks: how many are found, and how much else.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "estancia/files/csv.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

class HomeSegmentation : public testing::Test {
 protected:
  Findings run(const std::string& config) {
    writeFile(scratch_ / "home.toml", "type = \"home-segmentation\"\n" + config);
    Progress silent;
    return runExperiment({scratch_ / "home.toml"}, {scratch_ / "out", {}, {}, nullptr}, silent);
  }
  /// By class, noise and column.
  std::map<std::string, std::map<std::string, double>> results() const {
    std::map<std::string, std::map<std::string, double>> all;
    const auto rows = io::readCsv(scratch_ / "out/results.csv");
    for (std::size_t r = 1; r < rows.size(); ++r)
      for (std::size_t c = 3; c < rows[r].cells.size(); ++c)
        all[rows[r].cells[2] + " " + rows[r].cells[1]][rows[0].cells[c]] = std::stod(rows[r].cells[c]);
    return all;
  }

  test::ScratchFolder scratch_;
};

TEST_F(HomeSegmentation, FindsMostThingsAndFewOthers) {
  const auto data = test::findData("home_a");
  ESTANCIA_NEEDS(data, "needs home_a");
  const Findings findings =
      run("drives = [\"" + (*data / "day").string() +
          "\"]\nnoise = [0, 0.0012]\nevery = 16\n[classes]\nflat = [\"rug\", \"painting\", \"mirror\"]\n"
          "large = [\"sofa\", \"bed\", \"coffee_table\", \"armchair\", \"dining_table\"]\n");
  EXPECT_EQ(findings.sections.size(), 2U);
  auto found = results();
  for (const std::string noise : {" 0", " 0.0012"}) {
    EXPECT_GE(found["large" + noise]["found"], 0.55 * found["large" + noise]["things"]) << noise;
    EXPECT_GE(found["all" + noise]["found"], 0.4 * found["all" + noise]["things"]) << noise;
    EXPECT_GE(found["all" + noise]["right"], 0.4 * found["all" + noise]["clusters"]) << noise;
    EXPECT_LE(found["flat" + noise]["found"], 0.2 * found["flat" + noise]["things"]) << "they are structure";
    EXPECT_GE(found["flat" + noise]["structure"], 0.6 * found["flat" + noise]["things"]);
    EXPECT_LE(found["large" + noise]["structure"], 0.2 * found["large" + noise]["things"]);
    EXPECT_EQ(found["structure" + noise]["right"], 0);
    EXPECT_GT(found["large" + noise]["things"], 5) << noise;
  }
}

TEST_F(HomeSegmentation, SaysWhatIsWrong) {
  EXPECT_THAT([&] { run("drives = [\"nowhere\"]\n[classes]\n"); },
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT([&] { run("[classes]\n"); }, FailsWith(ErrorCode::malformedFile, "`drives`"));
  EXPECT_THAT([&] { run("drives = [\"a\"]\n[classes]\nx = [\"rug\"]\ny = [\"rug\"]\n"); },
              FailsWith(ErrorCode::malformedFile, "home.toml:5", "rug"));
  EXPECT_THAT([&] { run("drives = [\"a\"]\n[classes]\nall = [\"rug\"]\n"); },
              FailsWith(ErrorCode::malformedFile, "home.toml:4", "\"all\""));
  EXPECT_THAT([&] { run("drives = [\"a\"]\nother = \"structure\"\n[classes]\n"); },
              FailsWith(ErrorCode::malformedFile, "home.toml:3", "\"structure\""));
  EXPECT_THAT([&] { run("drives = [\"a\"]\nnoise = [-1]\n[classes]\n"); },
              FailsWith(ErrorCode::malformedFile, "`noise`"));
}

TEST(HomeKnownObjects, SayWhatIsWrong) {
  const test::ScratchFolder scratch;
  const auto run = [&](const std::string& config) {
    writeFile(scratch / "known.toml", "type = \"home-known-objects\"\n" + config);
    Progress silent;
    runExperiment({scratch / "known.toml"}, {scratch / "out", {}, {}, nullptr}, silent);
  };
  EXPECT_THAT([&] { run("drives = [\"nowhere\", \"elsewhere\"]\n"); }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT([&] { run(""); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { run("drives = [\"a\", \"b\"]\nmodels = 0\n"); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::experiments
