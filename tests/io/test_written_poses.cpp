// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "estancia/core/error.hpp"
#include "estancia/io/trajectory.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

std::vector<Frame> frames(bool stamped) {
  std::vector<Frame> result(4);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].name = "frame " + std::to_string(i);
    if (stamped) result[i].timestamp = 10 + static_cast<double>(i);
    if (i != 0) result[i].pose = Pose{.x = static_cast<double>(i), .y = 0.1};
  }
  return result;
}

TEST(WrittenPoses, GoByTimeWhereFramesHaveStamps) {
  const ScratchFolder folder;
  writePoses(frames(true), folder / "t.txt");
  const auto read = readTrajectory(folder / "t.txt");
  ASSERT_EQ(read.points.size(), 3U);
  EXPECT_EQ(read.points[0].timestamp, 11);
  EXPECT_EQ(read.points[0].pose->x, 1);
}

TEST(WrittenPoses, GoByOrderOtherwiseEvenWhenTheFirstIsLost) {
  const ScratchFolder folder;
  writePoses(frames(false), folder / "t.txt");
  const auto read = readTrajectory(folder / "t.txt");
  ASSERT_EQ(read.points.size(), 4U);
  EXPECT_FALSE(read.points[0].pose);
  ASSERT_TRUE(read.points[3].pose);
  EXPECT_EQ(read.points[3].pose->x, 3);
}

TEST(WrittenPoses, NoPoseAtAllIsRefused) {
  const ScratchFolder folder;
  EXPECT_THROW(writePoses(std::vector<Frame>(2), folder / "t.txt"), Error);
}

}  // namespace
}  // namespace estancia::test
