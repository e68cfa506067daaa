// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/time_left.hpp"

#include <gtest/gtest.h>

namespace estancia {
namespace {

TEST(TimeLeft, DoesNotCountTheStart) {
  TimeLeft left(100);
  EXPECT_FALSE(left.seconds(4));
  left.advance(1, 5);  // five seconds for opening the network
  EXPECT_FALSE(left.seconds(5)) << "of one item nothing can be told";
  for (int i = 1; i <= 12; ++i) left.advance(1, 5 + 0.5 * i);
  EXPECT_DOUBLE_EQ(left.rate(11).value(), 2);
  EXPECT_DOUBLE_EQ(left.seconds(11).value(), 87 / 2.0);
}

TEST(TimeLeft, CountsOnlyWhatWasDoneInThisRun) {
  TimeLeft left(1000, 900);
  left.advance(1, 1);
  left.advance(9, 4);
  EXPECT_EQ(left.done(), 910U);
  EXPECT_DOUBLE_EQ(left.seconds(4).value(), 30);
}

}  // namespace
}  // namespace estancia
