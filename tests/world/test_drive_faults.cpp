// Drive faults: poses that jump, and those that only look like it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estancia/world/drive_faults.hpp"

namespace estancia {
namespace {

/// Which poses along x [m] are believed, '+', of frames that are so many seconds apart, if that is known.
std::string believed(const std::vector<double>& path, std::optional<double> seconds) {
  PoseJumps jumps;
  std::string text;
  for (std::size_t i = 0; i < path.size(); ++i) {
    Frame frame;
    frame.name = std::to_string(i);
    if (seconds) frame.timestamp = static_cast<double>(i) * *seconds;
    text += jumps.add(i, frame, Pose::planar(path[i], 0, 0)) ? '+' : '-';
  }
  return text;
}

TEST(PoseJumps, AreFarFromWhereTheCameraWas) {
  EXPECT_EQ(believed({0, .1, .2, 100.3, .4, .5}, 0.1), "+++-++") << "there and back";
  EXPECT_EQ(believed({0, .1, .2, 3.3, .4, .5}, 0.1), "++++++") << "not twenty times as far as before";
  EXPECT_EQ(believed({0, .1, .2, 100, 100, 100.1, 100.2}, 0.1), "+++--++") << "it goes on from there";
}

TEST(PoseJumps, AreNoneWhereTheCameraWasAsFastBeforeOrHadTheTime) {
  EXPECT_EQ(believed({0, 3, 6, 9, 12, 15}, 0.1), "++++++");
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 8}, 60.0), "++++++");
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 8}, {}), "++++++") << "the next room";
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 20}, {}), "+++++-");
}

}  // namespace
}  // namespace estancia
