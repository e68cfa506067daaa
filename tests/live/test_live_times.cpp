// What the live loop knows of time.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/live_times.hpp"

#include <gtest/gtest.h>

namespace estancia {
namespace {

using namespace std::chrono_literals;

TEST(FramePeriod, IsThatOfTheCameraThoughFramesAreDroppedAndSomeAreLate) {
  FramePeriod period;
  FramePeriod::Time at{};
  for (const auto& [gap, dropped] : {std::pair{100ms, 0}, {100ms, 0}, {200ms, 1}}) {
    EXPECT_FALSE(period.value());
    period.add(at += gap, static_cast<std::size_t>(dropped));
  }
  EXPECT_FALSE(period.value()) << "two gaps tell little";
  period.add(at += 3s, 0);  // the camera was gone
  EXPECT_EQ(period.value(), 100ms);
  for (int i = 0; i < 15; ++i) period.add(at += 40ms, 0);
  EXPECT_EQ(period.value(), 40ms) << "of the last ones";
}

}  // namespace
}  // namespace estancia
