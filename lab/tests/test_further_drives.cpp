// Drives that follow another one: maps that are right and wrong about them.
// SPDX-License-Identifier: Apache-2.0
#include "places/further_drives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "color_drive.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

/// Five frames each, a meter apart; the second drive is half a meter off.
std::vector<Frame> twoDrives() {
  std::vector<Frame> frames(10);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].name = std::to_string(i);
    frames[i].pose = Pose::planar(static_cast<double>(i % 5) + (i < 5 ? 0 : 0.5), 0, 0);
    frames[i].room = i % 5 < 3 ? "hall" : "kitchen";
  }
  return frames;
}

TopologicalMap mapOf(const std::vector<int>& nodes) {
  TopologicalMap map{.vocabulary = Vocabulary({"bed"})};
  map.drives = {{.firstFrame = 0}, {.firstFrame = 5}};
  for (const int node : nodes) {
    MappedFrame frame;
    frame.node = node;
    map.frames.push_back(frame);
  }
  return map;
}

TEST(FurtherDrives, CountWhatIsKnownRightAndWrong) {
  const std::vector<Frame> truth = twoDrives();
  TopologicalMap map = mapOf({0, 0, 1, 2, 3, 4, 0, 0, 0, 2});
  map.merges = {{.frame = 9}, {.frame = 3}};
  map.frames[6].pose = Pose::planar(1.7, 0, 0);
  map.frames[7].pose = Pose::planar(2.5, 0.4, 0);
  const FurtherDrive found = furtherDriveIn(truth, map, false);
  EXPECT_EQ(found.frames, 5U);
  EXPECT_EQ(found.near, 5U);
  EXPECT_EQ(found.known, 4U) << "all but the first";
  EXPECT_EQ(found.right, 1U + 0U + 0U + 0U) << "1.5 m from 1 m";
  EXPECT_EQ(found.firstRight, 1U);
  EXPECT_EQ(found.grown, 1U) << "the kitchen is not in the hall; 2.5 m is, and 4.5 m is in the kitchen";
  EXPECT_EQ(found.wrong, 0U) << "it was in the hall";
  EXPECT_EQ(found.joined, 1U);
  EXPECT_NEAR(found.poseError.value(), 0.3, 1e-9);
  const FurtherDrive elsewhere = furtherDriveIn(truth, map, true);
  EXPECT_EQ(elsewhere.wrong, 4U);
  EXPECT_EQ(furtherDriveIn(truth, mapOf({0, 0, 1, 2, 3, 4, 0, 0, 3, 0}), false).wrong, 1U) << "the last";
  EXPECT_EQ(elsewhere.near, 0U);
  EXPECT_FALSE(elsewhere.poseError);
}

TEST(FurtherDrives, NeedWhatTheyAreComparedWith) {
  std::vector<Frame> truth = twoDrives();
  const TopologicalMap map = mapOf(std::vector<int>(10, 0));
  truth[3].pose.reset();
  EXPECT_THAT(test::caught([&] { furtherDriveIn(truth, map, false); }),
              FailsWith(ErrorCode::insufficientData, "3"));
  truth.pop_back();
  EXPECT_THAT(test::caught([&] { furtherDriveIn(truth, map, false); }), FailsWith(ErrorCode::mismatch));
}

TEST(FurtherDrivesExperiment, GoesOnAndMerges) {
  const test::ScratchFolder scratch;
  test::writeColorModel(scratch, "sharp", "0.02");
  test::writeColorDrive(scratch / "drive", 1);
  test::writeColorDrive(scratch / "again", 2);
  writeFile(scratch / "further.toml",
            "type = \"further-drives\"\n[[drive]]\nname = \"again\"\npath = \"drive\"\n"
            "then = { path = \"again\" }\nskip = 4\n");
  Progress progress;
  const Findings found = runExperiment({scratch / "further.toml"},
                                       {scratch / "out", {scratch / "sharp"}, {"", 1}, nullptr}, progress);
  ASSERT_EQ(found.sections.size(), 1U);
  const auto& table = std::get<ResultTable>(found.sections[0]);
  ASSERT_EQ(table.rows.size(), 4U) << "the drives have no depth";
  std::map<std::string, std::size_t> columns;
  for (std::size_t c = 0; c < table.columns.size(); ++c) columns[table.columns[c].name] = c;
  for (const auto& row : table.rows) {
    EXPECT_EQ(row.values.at(columns.at("frames")), 36) << row.name;
    EXPECT_EQ(row.values.at(columns.at("wrong")), 0) << row.name;
    EXPECT_GE(row.values.at(columns.at("right")), 18) << row.name;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch / "out/.map.estancia"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "out/.more.estancia"));
}

}  // namespace
}  // namespace estancia::experiments
