// What is wrong with the poses of a drive.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/drive_faults.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace estancia {
namespace {

Frame frameAt(const std::string& name, const std::optional<double>& time) {
  return {name, time, std::nullopt, ""};
}

/// Which frames of a drive along x are believed; `seconds` between frames, nothing without time stamps.
std::string believed(const std::vector<double>& path, const std::optional<double>& seconds,
                     std::size_t* jumps = nullptr) {
  PoseJumps found;
  std::string text;
  for (std::size_t i = 0; i < path.size(); ++i) {
    text +=
        found.add(i, frameAt("frame", seconds ? std::optional(static_cast<double>(i) * *seconds) : seconds),
                  Pose::planar(path[i], 0, 0))
            ? '+'
            : '-';
    if (jumps != nullptr && found.found()) ++*jumps;
  }
  return text;
}

TEST(PoseJumps, AreFarFromWhereTheCameraWas) {
  std::size_t jumps = 0;
  EXPECT_EQ(believed({0, .1, .2, 100.3, .4, .5}, 0.1, &jumps), "+++-++");
  EXPECT_EQ(jumps, 2U) << "there and back";
  EXPECT_EQ(believed({0, .1, .2, 3.3, .4, .5}, 0.1), "++++++") << "not twenty times as far as before";
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0}, 0.1), "++++++++++-+") << "now it is";
  EXPECT_EQ(believed({0, .1, .2, 100, 100, 100.1, 100.2}, 0.1), "+++--++") << "it goes on from there";
  EXPECT_EQ(believed({0, .1, .2, 100, 200, 300, .3}, 0.1), "+++---+") << "nowhere twice";
}

TEST(PoseJumps, AreNoneWhereThereWasTimeToGo) {
  std::vector<double> slow(20), photos(20);
  for (std::size_t i = 0; i < 20; ++i) photos[i] = 3 * static_cast<double>(i);
  slow.push_back(8);
  EXPECT_EQ(believed(slow, 60.0), std::string(21, '+'));
  EXPECT_EQ(believed(slow, {}), std::string(21, '+')) << "the next room";
  slow.back() = 20;
  EXPECT_EQ(believed(slow, {}), std::string(20, '+') + "-");
  EXPECT_EQ(believed(photos, 0.1), std::string(20, '+')) << "it is always as fast";
}

}  // namespace
}  // namespace estancia
