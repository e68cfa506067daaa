// Names of samples by labelers and shapes, and which of these names to doubt.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/late_fusion.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/training.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::MadeUpThings;
using test::madeUpThings;
using test::rows;
using test::saying;
using testing::ElementsAre;
using testing::IsEmpty;
using Source = FusedAnswer::Source;

ClassifierOptions quick() {
  ClassifierOptions options;
  options.c = 3;
  options.gamma = 1;
  return options;
}

const Features& shapelessFeatures() {
  static const Features none{{}, {}, DescriptorMatrix(0)};
  return none;
}

std::vector<int> names(PseudoLabeling naming, const ClassProbabilities& shares,
                       const std::vector<int>& instances, const Features& shapes = shapelessFeatures()) {
  return assignPseudoLabels(naming, shares, instances, shapes, quick());
}

TEST(Names, TopIsTheLikeliestOfEachSample) {
  const ClassProbabilities said{rows({{0.1F, 0.9F}, {0.5F, 0.5F}, {0, 0}}), {1, 1, 0}};
  EXPECT_THAT(names(PseudoLabeling::top, said, {0, 0, 0}), ElementsAre(1, 0, -1));
}

TEST(Names, VotedPoolsAllThatIsSaidOfAThing) {
  const ClassProbabilities said{
      rows({{0.6F, 0.4F}, {0.6F, 0.4F}, {0.05F, 0.95F}, {0, 0}, {0.9F, 0.1F}, {0, 0}}), {1, 1, 1, 0, 1, 0}};
  // The sure answer outweighs two doubtful ones; what is silent goes with its thing.
  EXPECT_THAT(names(PseudoLabeling::voted, said, {7, 7, 7, 7, -2, 5}), ElementsAre(1, 1, 1, 1, 0, -1));
}

TEST(Names, NothingSaidIsNoName) {
  const ClassProbabilities silent{rows({{0, 0}, {0, 0}}), {0, 0}};
  const MadeUpThings two = madeUpThings(1, 1, 2, 1);
  for (const PseudoLabeling naming : {PseudoLabeling::top, PseudoLabeling::voted, PseudoLabeling::confident})
    EXPECT_THAT(names(naming, silent, {0, 1}, two.shapes), ElementsAre(-1, -1));
  const ClassProbabilities none{DescriptorMatrix(2), {}};
  for (const PseudoLabeling naming : {PseudoLabeling::top, PseudoLabeling::voted, PseudoLabeling::confident})
    EXPECT_THAT(names(naming, none, {}), ElementsAre());
  EXPECT_THAT([&] { names(PseudoLabeling::voted, silent, {0}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_EQ(getPseudoLabeling("confident"), PseudoLabeling::confident);
  EXPECT_THAT([] { getPseudoLabeling("best"); }, FailsWith(ErrorCode::unknownName));
}

TEST(Names, ConfidentLeavesOutWhatShapesSpeakAgainst) {
  const MadeUpThings things = madeUpThings(4, 5, 8, 1);
  std::vector<int> wrong = things.classes;
  for (std::size_t i = 0; i < wrong.size(); i += 5) wrong[i] = (wrong[i] + 1 + static_cast<int>(i) % 3) % 4;
  const std::vector<int> kept =
      names(PseudoLabeling::confident, saying(wrong, 4), things.instances, things.shapes);
  std::size_t wrongBefore = 0, wrongAfter = 0, rightLost = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_TRUE(kept[i] == -1 || kept[i] == wrong[i]);
    wrongBefore += wrong[i] != things.classes[i] ? 1 : 0;
    wrongAfter += kept[i] >= 0 && kept[i] != things.classes[i] ? 1 : 0;
    rightLost += kept[i] < 0 && wrong[i] == things.classes[i] ? 1 : 0;
  }
  EXPECT_EQ(wrongBefore, 32U);
  EXPECT_LT(wrongAfter, wrongBefore / 4);
  EXPECT_LT(rightLost, 10U);
}

/// A word that cannot be held out is not doubted, and one word alone has no other to be compared with.
TEST(Names, ConfidentDoubtsNothingThatItCannotJudge) {
  MadeUpThings things = madeUpThings(3, 3, 8, 1);
  for (std::size_t i = 0; i < things.classes.size(); ++i)
    if (things.classes[i] == 2) things.instances[i] = 100;
  std::vector<int> few = things.classes;
  int seen = 0;  // word 2: one thing of two samples; the others are not restricted
  for (int& word : few)
    if (word == 2 && ++seen > 2) word = -1;
  ClassProbabilities said{DescriptorMatrix(3), std::vector<float>(few.size(), 1)};
  for (const int word : few) {
    std::vector<float> row(3);
    if (word >= 0) row[static_cast<std::size_t>(word)] = 1;
    said.probabilities.append(row);
  }
  const std::vector<int> kept = names(PseudoLabeling::confident, said, things.instances, things.shapes);
  EXPECT_EQ(std::ranges::count(kept, 2), 2);
  const ClassProbabilities alike = saying(std::vector<int>(things.classes.size(), 1), 3);
  EXPECT_THAT(names(PseudoLabeling::confident, alike, things.instances, things.shapes), testing::Each(1));
}

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

/// Words mug and bowl, whose held-out shapes are mostly right; can, which cannot be held out.
ObjectModel model() {
  test::MadeUpThings things = test::madeUpThings(3, 4, 6, 1);
  for (std::size_t i = 0; i < things.classes.size(); ++i)
    if (things.classes[i] == 2 && (things.instances[i] != 8 || i % 6 > 1)) things.classes[i] = -1;
  return trainObjectModel(
      {targetClassesOf({"mug", "bowl", "can"}), {}, things.shapes, things.classes, things.instances, "", {}},
      quick());
}

class LateFusion : public testing::Test {
 protected:
  static const ObjectModel& learned() {
    static const ObjectModel once = model();
    return once;
  }
  FusedAnswer fused() {
    evidence_.image = image_;
    evidence_.shape = shape_;
    return fuseAnswers(learned(), evidence_);
  }
  std::vector<float> image_{0.8F, 0.1F, 0.1F}, shape_{0.7F, 0.2F, 0.1F};
  ObjectEvidence evidence_{.coverage = 0.5F, .brightness = 0.6};
};

TEST_F(LateFusion, InBothWhereTheyAgreeAndInNothingFlat) {
  FusedAnswer answer = fused();
  EXPECT_EQ(answer.source, Source::both);
  EXPECT_EQ(answer.classIndex, 0);
  EXPECT_NEAR(answer.probability, 0.8, 1e-6);
  evidence_.flat = true;
  answer = fused();
  EXPECT_EQ(answer.source, Source::none);
  EXPECT_EQ(answer.classIndex, -1);
  EXPECT_EQ(answer.probability, 0);
}

TEST_F(LateFusion, InTheShapeWhereTheImageTellsNothing) {
  shape_ = {0.1F, 0.3F, 0.6F};
  const auto expectShape = [&] {
    const FusedAnswer answer = fused();
    EXPECT_EQ(answer.source, Source::shape);
    EXPECT_EQ(answer.classIndex, 2);
  };
  evidence_.brightness = 0.04;
  expectShape();
  evidence_.brightness = NAN;
  expectShape();
  evidence_.brightness = 0.5;
  evidence_.coverage = 0.004F;
  expectShape();
  image_ = {0, 0, 0};
  expectShape();
  image_.clear();
  expectShape();
}

TEST_F(LateFusion, InTheImageWhereThereIsNoShape) {
  shape_.clear();
  FusedAnswer answer = fused();
  EXPECT_EQ(answer.source, Source::image);
  EXPECT_EQ(answer.classIndex, 0);
  EXPECT_NE(answer.why, "");
  evidence_.brightness = 0;
  answer = fused();
  EXPECT_EQ(answer.source, Source::none);
  EXPECT_EQ(answer.classIndex, -1);
  image_.clear();
  EXPECT_EQ(fused().source, Source::none);
  evidence_.flat = true;
  EXPECT_EQ(fused().source, Source::none);
}

TEST_F(LateFusion, InWhatIsMoreLikelyWhereTheyDiffer) {
  ASSERT_GT(learned().heldOutAccuracy()[1], 0.9F);
  shape_ = {0.4F, 0.6F, 0};
  FusedAnswer answer = fused();
  EXPECT_EQ(answer.source, Source::shape);
  EXPECT_EQ(answer.classIndex, 1);
  EXPECT_NEAR(answer.probability, 0.6, 1e-6);
  shape_ = {0.3F, 0.35F, 0.34F};
  image_ = {0.99F, 0.01F, 0};
  answer = fused();
  EXPECT_EQ(answer.source, Source::image);
  EXPECT_EQ(answer.classIndex, 0);
  shape_ = {0.1F, 0.2F, 0.7F};
  image_ = {0.6F, 0.3F, 0.1F};
  EXPECT_EQ(fused().classIndex, 2) << "how accurate such shapes are is unknown, and does not count";
}

TEST_F(LateFusion, OtherWordsAreRefused) {
  image_ = {0.5F, 0.5F};
  EXPECT_THAT([&] { fused(); }, FailsWith(ErrorCode::mismatch));
  image_ = {0.5F, NAN, 0.1F};
  EXPECT_THAT([&] { fused(); }, FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
