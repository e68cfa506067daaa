// Outputs → probabilities.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estancia/label/scores.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::FloatNear;
using Values = std::vector<float>;

ModelSpec detector() {
  ModelSpec spec;
  spec.name = "detector";
  spec.reduce = ModelSpec::Reduce::max;
  spec.sigmoid = true;
  spec.unused = {0, 2};
  return spec;
}

float sigmoid(float x) {
  return 1 / (1 + std::exp(-x));
}

TEST(Scores, OfADetectorAreThoseOfTheSurestPlace) {
  const Values output{9, 1,  9, -3,  //
                      9, -2, 9, 2,   //
                      9, 0,  9, -90};
  EXPECT_THAT(toProbabilities(output, detector(), 2),
              ElementsAre(FloatNear(sigmoid(1), 1e-6F), FloatNear(sigmoid(2), 1e-6F)));
}

TEST(Scores, OfFeaturesAreSharesOfTheirSum) {
  ModelSpec spec;
  spec.features = 3;
  EXPECT_THAT(toProbabilities(Values{1, 3, 0}, spec, 3), ElementsAre(0.25F, 0.75F, 0));
  EXPECT_THAT(toProbabilities(Values{0, 0, 0}, spec, 3), ElementsAre(0, 0, 0));
  EXPECT_THAT([&] { toProbabilities(Values{1, -1, 0}, spec, 3); }, FailsWith(ErrorCode::mismatch));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT([&] { toProbabilities(Values{1, nan, 0}, spec, 3); }, FailsWith(ErrorCode::labelerFailure));
}

TEST(Scores, OfASigmoidNeverOverflow) {
  EXPECT_THAT(toProbabilities(Values{0, 1000, 0, -1000}, detector(), 2), ElementsAre(1, 0));
}

TEST(Scores, OfASoftmaxAreTakenWithUnusedOutputsInEachRow) {
  ModelSpec spec = detector();
  spec.sigmoid = false;
  spec.softmax = true;
  spec.unused = {0};
  const float strong = std::exp(2.0F) / (1 + std::exp(2.0F)), half = 0.5F;
  EXPECT_THAT(toProbabilities(Values{0, 2, 5, 5}, spec, 1), ElementsAre(FloatNear(strong, 1e-6F)));
  EXPECT_THAT(toProbabilities(Values{5, 5}, spec, 1), ElementsAre(FloatNear(half, 1e-6F)));
}

TEST(Scores, AreRefusedWhenOneRowIsExpectedOrARowIsNotWhole) {
  ModelSpec spec = detector();
  EXPECT_THAT([&] { toProbabilities(Values(7), spec, 2); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { toProbabilities(Values{}, spec, 2); }, FailsWith(ErrorCode::mismatch));
  spec.reduce = ModelSpec::Reduce::none;
  EXPECT_THAT([&] { toProbabilities(Values(8), spec, 2); }, FailsWith(ErrorCode::mismatch));
  EXPECT_EQ(toProbabilities(Values(4), spec, 2).size(), 2U);
  spec.unused = {0, 4};
  EXPECT_THAT([&] { toProbabilities(Values(8), spec, 2); }, FailsWith(ErrorCode::mismatch));
}

TEST(Scores, AreRefusedWhenAnyRowIsNotANumber) {
  for (std::size_t row = 0; row < 3; ++row) {
    Values output(12);
    output[row * 4 + 1] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT([&] { toProbabilities(output, detector(), 2); }, FailsWith(ErrorCode::labelerFailure)) << row;
  }
}

}  // namespace
}  // namespace estancia
