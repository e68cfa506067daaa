// Numbers of groups that are found anew.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/kept_numbers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace estancia {
namespace {

using testing::ElementsAre;

TEST(KeptNumbers, AreThoseOfTheLargestOverlap) {
  // Group 0 is what was 2, group 1 what was 0; group 2 is new.
  EXPECT_THAT(keptNumbers(3, {{{0, 2}, 50}, {{0, 0}, 3}, {{1, 0}, 20}}), ElementsAre(2, 0, 1));
}

TEST(KeptNumbers, AreGivenOnce) {
  // A split: the larger part keeps the number.
  EXPECT_THAT(keptNumbers(2, {{{0, 0}, 30}, {{1, 0}, 70}}), ElementsAre(1, 0));
  // Merged: the number of what was more of it.
  EXPECT_THAT(keptNumbers(1, {{{0, 1}, 70}, {{0, 0}, 30}}), ElementsAre(0)) << "1 would leave a gap";
}

TEST(KeptNumbers, OfGroupsWithoutEarlierOnesAreInOrder) {
  EXPECT_THAT(keptNumbers(3, {}), ElementsAre(0, 1, 2));
  EXPECT_THAT(keptNumbers(0, {}), ElementsAre());
  EXPECT_THAT(keptNumbers(2, {{{7, 0}, 5}, {{0, 9}, 5}}), ElementsAre(0, 1)) << "none of these";
}

}  // namespace
}  // namespace estancia
