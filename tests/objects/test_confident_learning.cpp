// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::rows;
using testing::ElementsAre;
using testing::IsEmpty;

/// Worked by hand. Thresholds .58 and .65; sample 3 is sure of neither word, so of name 0 three count for 0
/// and one for 1: 5/4 are wrong. For name 1 two count for 1, one for 0, one for neither: 4/3 are.
TEST(ConfidentLearning, TakesAsManyAsTheNoiseRateSays) {
  EXPECT_THAT(likelyMislabeled({0, 0, 0, 0, 0, 1, 1, 1, 1}, rows({{0.9F, 0.1F},
                                                                  {0.8F, 0.2F},
                                                                  {0.7F, 0.3F},
                                                                  {0.4F, 0.6F},
                                                                  {0.1F, 0.9F},
                                                                  {0.1F, 0.9F},
                                                                  {0.2F, 0.8F},
                                                                  {0.7F, 0.3F},
                                                                  {0.4F, 0.6F}})),
              ElementsAre(4, 7));
}

/// For name 0 two count for 0 and one for 1, so 5/3 are wrong; but only one sample speaks for 1.
TEST(ConfidentLearning, LeavesSamplesThatAreSurestOfTheirName) {
  EXPECT_THAT(likelyMislabeled({0, 0, 0, 0, 0, 1, 1}, rows({{0.99F, 0.01F},
                                                            {0.99F, 0.01F},
                                                            {0.55F, 0.45F},
                                                            {0.55F, 0.45F},
                                                            {0.05F, 0.95F},
                                                            {0.1F, 0.9F},
                                                            {0.1F, 0.9F}})),
              ElementsAre(4));
}

TEST(ConfidentLearning, NothingIsSaidAgainstWhatCannotBeJudged) {
  // Nothing is called by word 2, so it is unknown how sure samples of it would be.
  EXPECT_THAT(
      likelyMislabeled({0, 0, 1, 1}, rows({{0.9F, 0.1F, 0}, {0.4F, 0.1F, 0.5F}, {0, 1, 0}, {0, 1, 0}})),
      IsEmpty());
  // Samples that were not held out.
  EXPECT_THAT(likelyMislabeled({0, 0, 1, 1}, rows({{0.9F, 0.1F}, {0.9F, 0.1F}, {0, 0}, {0, 0}})), IsEmpty());
  EXPECT_THAT(likelyMislabeled({}, DescriptorMatrix(2)), IsEmpty());
  const DescriptorMatrix one = rows({{1, 0}});
  EXPECT_THAT([&] { likelyMislabeled({0, 1}, one); }, test::FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia
