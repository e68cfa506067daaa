// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/proportion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

// scipy.stats.binomtest(k, n).proportion_ci(method="wilson")
TEST(WilsonInterval, IsSciPys) {
  const auto expectInterval = [](std::size_t hits, std::size_t trials, double low, double high) {
    const auto interval = wilsonInterval(hits, trials);
    EXPECT_NEAR(interval.first, low, 1e-9) << hits;
    EXPECT_NEAR(interval.second, high, 1e-9) << hits;
  };
  expectInterval(0, 10, 0, 0.277532799863);
  expectInterval(10, 10, 0.722467200137, 1);
  expectInterval(1, 1, 0.206549314377, 1);
  expectInterval(397, 516, 0.731124278461, 0.803654153084);
  expectInterval(4, 7, 0.250458364528, 0.841780144749);
}

TEST(WilsonInterval, RefusesWhatIsNoShare) {
  EXPECT_THAT([] { wilsonInterval(std::size_t{0}, std::size_t{0}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(std::size_t{3}, std::size_t{2}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(1.5, 2.0); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(0.5, 0.0); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
