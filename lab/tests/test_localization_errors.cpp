// A drive through four colors, found in the map of another one.
// SPDX-License-Identifier: Apache-2.0
#include "places/localization_errors.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "color_drive.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;

class LocalizationErrors : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    test::writeColorModel(scratch_, "blind", "1e-9");
    test::writeColorDrive(scratch_ / "drive", 1);
    test::writeColorDrive(scratch_ / "again", 2);
    std::string poses;  // a level camera that drives 3 m a room and looks ahead
    for (int i = 0; i < 40; ++i) poses += fmt::format("{} {} 0 1 -0.5 0.5 -0.5 0.5\n", i, 0.3 * i);
    for (const char* drive : {"drive", "again"})
      writeFile(scratch_ / (std::string(drive) + "/poses.txt"), poses);
  }

  const std::string drive_ =
      "[[drive]]\nname = \"four\"\npath = \"drive\"\n[drive.again]\npath = \"again\"\n";

  Findings run(const std::string& text) {
    writeFile(scratch_ / "find.toml", "type = \"localization\"\n" + text);
    return runExperiment({scratch_ / "find.toml"},
                         {scratch_ / "out", {scratch_ / "sharp", scratch_ / "blind"}, {"", 1}, nullptr},
                         progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

const std::optional<double>& valueAt(const ResultTable& table, std::size_t row, const std::string& column) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].name == column) return table.rows.at(row).values[c];
  throw std::out_of_range(column);
}

TEST_F(LocalizationErrors, TheModelThatSeesIsRight) {
  const Findings found = run("lookaheads = [2, 5]\n" + drive_);
  ASSERT_EQ(found.sections.size(), 2U) << "a table a model";
  const auto& sharp = std::get<ResultTable>(found.sections[0]);
  const auto& blind = std::get<ResultTable>(found.sections[1]);
  ASSERT_EQ(sharp.rows.size(), 4U) << "nearest, believed, and two with lookahead";
  EXPECT_EQ(valueAt(sharp, 0, "frames"), 40);
  EXPECT_EQ(valueAt(sharp, 0, "with a near image"), 40);
  EXPECT_GT(valueAt(sharp, 0, "recall@1").value(), valueAt(blind, 0, "recall@1").value() + 0.2);
  EXPECT_GT(valueAt(sharp, 0, "right room"), 0.95);
  EXPECT_GT(valueAt(sharp, 3, "right room, by place"), 0.9);
  EXPECT_LT(valueAt(sharp, 1, "median error [m]"), 1) << "the filter follows the motion";
  EXPECT_LT(valueAt(blind, 0, "right room"), 0.8);
}

TEST_F(LocalizationErrors, AreTheSameAgain) {
  run(drive_);
  const std::string before = readFile(scratch_ / "out/results.csv");
  std::filesystem::remove_all(scratch_ / "out");
  run(drive_);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
}

TEST_F(LocalizationErrors, SayWhatIsWrongAndWhere) {
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"drive\"\n"),
              FailsWith(ErrorCode::malformedFile, "`again`"));
  EXPECT_THAT(problem("lookaheads = [0]\n" + drive_), FailsWith(ErrorCode::malformedFile, "`lookaheads`"));
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"drive\"\n[drive.again]\npath = \"nowhere\"\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
}

}  // namespace
}  // namespace estancia::experiments
