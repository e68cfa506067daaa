// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/core/error.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::madeUpThings;
using test::MadeUpThings;
using test::rows;
using test::saying;
using testing::ElementsAre;

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
  EXPECT_THAT(names(PseudoLabeling::confident, alike, things.instances, things.shapes), Each(1));
}

}  // namespace
}  // namespace estancia
