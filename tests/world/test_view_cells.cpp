// Which views of a drive are kept.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/view_cells.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace estancia {
namespace {

TEST(ViewCells, KeepEightViewsOfACellThenOneEachTimeTheDriveDoubles) {
  ViewCells cells;
  std::vector<std::size_t> kept;
  for (std::size_t frame = 0; frame < 100; ++frame)
    if (const Pose pose = Pose::planar(1.1, 2.1, 0.3); cells.wants(frame, pose)) {
      cells.add(frame, pose);
      kept.push_back(frame);
    }
  EXPECT_EQ(kept, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 14, 28, 56}));
}

TEST(ViewCells, ViewsFromElsewhereAndInOtherDirectionsAreOthers) {
  ViewCells cells;
  const Pose pose = Pose::planar(1.1, 2.1, 0);
  for (std::size_t frame = 0; frame < 8; ++frame) cells.add(frame, pose);
  EXPECT_FALSE(cells.wants(8, pose));
  EXPECT_FALSE(cells.wants(8, Pose::planar(1.2, 2.2, 0.1)));
  EXPECT_TRUE(cells.wants(8, Pose::planar(1.8, 2.1, 0)));
  EXPECT_TRUE(cells.wants(8, Pose::planar(1.1, 2.1, 0.7)));
  EXPECT_TRUE(cells.wants(8, Pose::planar(1.1, 2.1, std::numbers::pi)));
}

TEST(ViewCells, ADayInOneRoomKeepsNoMoreViewsThanTheRoomHas) {
  ViewCells cells;
  std::size_t kept = 0, early = 0;
  constexpr std::size_t frames = 100'000, round = 200;  // a circle of 1 m, over and over
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(frame % round) / round;
    const Pose pose = Pose::planar(std::cos(angle), std::sin(angle), angle);
    if (!cells.wants(frame, pose)) continue;
    cells.add(frame, pose);
    ++kept;
    if (frame < 2000) ++early;
  }
  EXPECT_LE(kept, 2 * early);
  EXPECT_LE(kept, 1000U);
}

TEST(ViewCells, TakeQuaternionsThatAreNone) {
  ViewCells cells;
  const double huge = std::numeric_limits<double>::max();
  cells.add(0, {0, 0, 0, huge, huge, -huge, huge});
  EXPECT_TRUE(cells.wants(1, {0, 0, 0, huge, huge, -huge, huge}));
}

}  // namespace
}  // namespace estancia
