// Where the rows of a detector's output look.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/default_boxes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(DefaultBoxes, AreThoseOfTheSingleShotDetector) {
  const auto boxes = defaultBoxes(std::array{19, 10, 5, 3, 2, 1});
  ASSERT_EQ(boxes.size(), 1917U);  // of the published network
  const auto expectBox = [&](std::size_t i, double x, double y, double width, double height) {
    EXPECT_NEAR(boxes[i].x + boxes[i].width / 2, x, 1e-6) << i;
    EXPECT_NEAR(boxes[i].y + boxes[i].height / 2, y, 1e-6) << i;
    EXPECT_NEAR(boxes[i].width, width, 1e-6) << i;
    EXPECT_NEAR(boxes[i].height, height, 1e-6) << i;
  };
  expectBox(0, 0.5 / 19, 0.5 / 19, 0.1, 0.1);
  expectBox(1, 0.5 / 19, 0.5 / 19, 0.2828427, 0.1414214);
  expectBox(3, 1.5 / 19, 0.5 / 19, 0.1, 0.1);             // the next cell of the row
  expectBox(19 * 3, 0.5 / 19, 1.5 / 19, 0.1, 0.1);        // the next row
  expectBox(1083, 0.05, 0.05, 0.35, 0.35);                // the second grid
  expectBox(1083 + 5, 0.05, 0.05, 0.4183300, 0.4183300);  // √(0.35 · 0.5)
  expectBox(1911, 0.5, 0.5, 0.95, 0.95);                  // the last one
  expectBox(1916, 0.5, 0.5, 0.9746794, 0.9746794);        // √(0.95 · 1)
}

TEST(DefaultBoxes, OfARegionAreThoseThatOverlapItOrElseTheBest) {
  const std::array<cv::Rect2d, 3> boxes{cv::Rect2d(0, 0, 0.5, 0.5), cv::Rect2d(0, 0, 0.5, 0.6),
                                        cv::Rect2d(0.5, 0.5, 0.5, 0.5)};
  EXPECT_THAT(boxesOf({0, 0, 0.5, 0.5}, boxes), ElementsAre(0, 1));
  EXPECT_THAT(boxesOf({0.55, 0.55, 0.02, 0.02}, boxes), ElementsAre(2)) << "small, and yet one looks at it";
  EXPECT_THAT(boxesOf({0.6, 0, 0.1, 0.1}, boxes), IsEmpty());
  EXPECT_THAT(boxesOf({0, 0, 0, 0}, boxes), IsEmpty());
}

}  // namespace
}  // namespace estancia
