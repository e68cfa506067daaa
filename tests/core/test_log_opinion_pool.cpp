// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/log_opinion_pool.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<double> pooled(const std::vector<std::vector<float>>& opinions) {
  LogOpinionPool pool(opinions.front().size());
  for (const auto& opinion : opinions) pool.add(opinion);
  return pool.pooled();
}

TEST(LogOpinionPool, IsTheScaledGeometricMean) {
  // sqrt(0.5 · 0.02) = 0.1, sqrt(0.5 · 0.98) = 0.7
  EXPECT_THAT(pooled({{0.5F, 0.5F}, {0.02F, 0.98F}}),
              ElementsAre(DoubleNear(0.125, 1e-6), DoubleNear(0.875, 1e-6)));
}

TEST(LogOpinionPool, AZeroIsNoProofAndNoOpinionIsNone) {
  EXPECT_GT(pooled({{0, 1}, {0.999F, 0.001F}, {0.999F, 0.001F}})[0], 0.5);
  LogOpinionPool pool(2);
  pool.add(std::vector<float>{0, 0});
  EXPECT_EQ(pool.size(), 0U);
  EXPECT_THAT(pool.pooled(), IsEmpty());
  EXPECT_THAT([&] { pool.add(std::vector<float>{1}); }, FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia::test
