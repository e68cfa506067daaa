// Places and rooms on made-up images: a model that sees colors must beat one that sees nothing.
// SPDX-License-Identifier: Apache-2.0
#include "places/place_tasks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "color_drive.hpp"
#include "estancia/core/error.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
namespace fs = std::filesystem;

class PlaceTasks : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    test::writeColorModel(scratch_, "blind", "1e-9");
    test::writeColorDrive(scratch_ / "drive", 1);
    test::writeColorDrive(scratch_ / "again", 2);
    std::string table = "number,kind,half\n";
    for (int i = 0; i < 40; ++i)
      table += std::to_string(i) + ",color" + std::to_string(i / 10) + (i % 2 == 0 ? ",train\n" : ",test\n");
    writeFile(scratch_ / "table.csv", table);
  }

  const std::string drive_ =
      "[[drive]]\nname = \"four\"\npath = \"drive\"\n[drive.again]\npath = \"again\"\n";
  const std::string rooms_ =
      "[[rooms]]\nname = \"colors\"\npath = \"drive\"\ntable = \"table.csv\"\nimage_column = \"number\"\n"
      "room_column = \"kind\"\nsplit_column = \"half\"\n";

  Findings run(const std::string& text) {
    writeFile(scratch_ / "tasks.toml", "type = \"places\"\n" + text);
    return runExperiment({scratch_ / "tasks.toml"},
                         {scratch_ / "out", {scratch_ / "sharp", scratch_ / "blind"}, {"", 1}, nullptr},
                         progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

double valueOf(const Findings& findings, std::size_t section, const std::string& model,
               const std::string& column) {
  const auto& table = std::get<ResultTable>(findings.sections.at(section));
  for (const auto& row : table.rows)
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      if (row.name == model && table.columns[c].name == column) return row.values[c].value();
  ADD_FAILURE() << "no " << column << " of " << model;
  return -1;
}

TEST_F(PlaceTasks, TheModelThatSeesWins) {
  const Findings found = run(drive_ + rooms_);
  EXPECT_GT(valueOf(found, 0, "sharp", "V-measure"), 0.9);
  EXPECT_GT(valueOf(found, 0, "sharp", "one image"), 0.95);
  EXPECT_LT(valueOf(found, 0, "blind", "one image"), 0.8);
  EXPECT_EQ(valueOf(found, 1, "sharp", "nearest neighbor"), 1);
  EXPECT_EQ(valueOf(found, 1, "sharp", "halves exchanged"), 1);
  EXPECT_LT(valueOf(found, 1, "blind", "nearest neighbor"), 0.8);
  for (const auto& entry : fs::directory_iterator(scratch_ / "out"))
    EXPECT_NE(entry.path().extension(), ".estancia") << "maps are made and gone";
}

TEST_F(PlaceTasks, AreTheSameAgainAndComputedOnce) {
  run(drive_ + rooms_);
  const std::string before = readFile(scratch_ / "out/results.csv");
  run(drive_ + rooms_);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
  fs::remove_all(scratch_ / "out");
  run(drive_ + rooms_);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before);
}

TEST_F(PlaceTasks, OnlyTheNamedRoomsCount) {
  const Findings found = run(rooms_ + "only = [\"color0\", \"color3\"]\n");
  EXPECT_EQ(valueOf(found, 0, "sharp", "nearest neighbor"), 1);
}

TEST_F(PlaceTasks, SayWhatIsWrongAndWhere) {
  EXPECT_THAT(problem(""), FailsWith(ErrorCode::insufficientData, "[[drive]]", "[[rooms]]"));
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"drive\"\n"),
              FailsWith(ErrorCode::malformedFile, "`again`"));
  EXPECT_THAT(problem(drive_ + "truht = \"x\"\n"), FailsWith(ErrorCode::malformedFile, "`truht`"));
  EXPECT_THAT(problem("[[rooms]]\nname = \"x\"\npath = \"drive\"\ntable = \"table.csv\"\n"),
              FailsWith(ErrorCode::malformedFile, "table.csv:1", "\"image\""));
  EXPECT_THAT(problem(rooms_ + "train = \"practice\"\n"),
              FailsWith(ErrorCode::insufficientData, "table.csv", "0 images"));
  writeFile(scratch_ / "table.csv", "number,kind,half\n0,color0\n");
  EXPECT_THAT(problem(rooms_), FailsWith(ErrorCode::malformedFile, "table.csv:2", "2 cells"));
  EXPECT_THAT(problem("[[drive]]\nname = \"x\"\npath = \"nowhere\"\n[drive.again]\nturn = 3\n"),
              FailsWith(ErrorCode::fileNotFound, "nowhere"));
  EXPECT_THAT(
      problem("[[drive]]\nname = \"x\"\npath = \"nowhere\"\noptional = true\n[drive.again]\nturn = 3\n"),
      FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia::experiments
