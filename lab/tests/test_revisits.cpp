// Returns to places: a drive there and back, and maps that are right and wrong about it.
// SPDX-License-Identifier: Apache-2.0
#include "places/revisits.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "color_drive.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

/// Three meters ahead in steps of 0.5 m and back again, looking east all the time: frames 9 … 12 are within
/// 0.7 m of frames 0 … 4, from before the robot was 1.4 m away.
std::vector<Frame> thereAndBack() {
  std::vector<Frame> frames(13);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].name = std::to_string(i);
    frames[i].pose = Pose::planar(0.5 * static_cast<double>(i <= 6 ? i : 12 - i), 0, 0);
  }
  return frames;
}

/// A map that puts these frames into these nodes, each change but the first of a node a return.
TopologicalMap mapOf(const std::vector<int>& nodes) {
  TopologicalMap map{.vocabulary = Vocabulary({"bed"})};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    MappedFrame frame;
    frame.node = nodes[i];
    Decision decision{.frame = i};
    const bool isKnown =
        std::count(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(i), nodes[i]) > 0;
    if (i > 0 && nodes[i] == nodes[i - 1])
      decision.kind = DecisionKind::join;
    else if (i > 0)
      decision.kind = isKnown ? DecisionKind::revisit : DecisionKind::createNode;
    map.frames.push_back(frame);
    map.decisions.push_back(decision);
  }
  return map;
}

TEST(Revisits, CountsWhatIsFoundAndWhatIsWrong) {
  const std::vector<Frame> frames = thereAndBack();
  const Revisits right = revisitsIn(frames, mapOf({0, 0, 0, 1, 1, 2, 2, 2, 1, 1, 0, 0, 0}));
  EXPECT_EQ(right.first, 9U);
  EXPECT_EQ(right.frames, 4U);
  EXPECT_EQ(right.found, 4U);
  EXPECT_EQ(right.firstFound, 9U);
  EXPECT_EQ(right.decisions, 2U);
  EXPECT_EQ(right.wrong, 0U);

  const Revisits late = revisitsIn(frames, mapOf({0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 3, 3, 0}));
  EXPECT_EQ(late.frames, 4U);
  EXPECT_EQ(late.found, 1U);
  EXPECT_EQ(late.firstFound, 12U);

  const Revisits wrong = revisitsIn(frames, mapOf({0, 0, 0, 1, 1, 2, 2, 2, 0, 0, 0, 0, 0}));
  EXPECT_EQ(wrong.decisions, 1U);
  EXPECT_EQ(wrong.wrong, 0U) << "frame 2 was taken a meter away";
  const Revisits lost = revisitsIn(frames, mapOf({0, 0, 0, 1, 1, 2, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(lost.wrong, 1U) << "two meters away";
}

TEST(Revisits, NeedsWhatItComparesWith) {
  std::vector<Frame> frames = thereAndBack();
  const TopologicalMap map = mapOf(std::vector<int>(13, 0));
  frames[3].pose.reset();
  EXPECT_THAT(test::caught([&] { revisitsIn(frames, map); }), FailsWith(ErrorCode::insufficientData, "3"));
  frames.pop_back();
  EXPECT_THAT(test::caught([&] { revisitsIn(frames, map); }), FailsWith(ErrorCode::mismatch));
}

TEST(RevisitsExperiment, MapsDrivesThereAndBack) {
  const test::ScratchFolder scratch;
  test::writeColorModel(scratch, "sharp", "0.02");
  test::writeColorDrive(scratch / "drive", 1);
  test::writeColorDrive(scratch / "again", 2);
  writeFile(scratch / "back.toml",
            "type = \"revisits\"\n[[drive]]\nname = \"once\"\npath = \"drive\"\n"
            "[[drive]]\nname = \"reversed\"\npath = \"drive\"\nreversed = true\n"
            "[[drive]]\nname = \"twice\"\npath = \"drive\"\nthen = { path = \"again\" }\n");
  Progress progress;
  const Findings found = runExperiment({scratch / "back.toml"},
                                       {scratch / "out", {scratch / "sharp"}, {"", 1}, nullptr}, progress);
  ASSERT_EQ(found.sections.size(), 2U) << "with poses, and by words alone";
  const auto& posed = std::get<ResultTable>(found.sections[0]);
  std::map<std::string, std::size_t> columns;
  for (std::size_t c = 0; c < posed.columns.size(); ++c) columns[posed.columns[c].name] = c;
  const auto at = [&](std::size_t drive, const std::string& column) {
    return posed.rows.at(drive).values.at(columns.at(column));
  };
  EXPECT_EQ(at(0, "back"), 0) << "rooms 3 m apart, once each";
  EXPECT_EQ(at(1, "back"), 0);
  EXPECT_EQ(at(2, "frames"), 80);
  EXPECT_EQ(at(2, "back"), 40);
  EXPECT_EQ(at(2, "found"), 40);
  EXPECT_EQ(at(2, "wrong"), 0);
  EXPECT_EQ(at(2, "first back"), 40);
}

}  // namespace
}  // namespace estancia::experiments
