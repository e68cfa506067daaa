// Which words objects make their classes of, by the labels of their images and by their shapes.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/own_classes.hpp"

#include <gmock/gmock.h>

#include "estancia/core/error.hpp"
#include "estancia/words/label_concepts.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const Vocabulary wordsOfThings({"mug, cup", "bottle", "folding chair", "rocking chair", "wall"});
const std::vector<float> surelyMug{.8F, .05F, .05F, .05F, .05F}, surelyChair{.05F, .05F, .45F, .4F, .05F},
    mugOrWall{.05F, .45F, 0, .05F, .45F};
const LabelConcepts chairWords{{"chair", 0.9, {2, 3}, {2, 3}}};

/// Three shapes, six things of each, three views a thing.
const MadeUpThings& threeShapes() {
  static const MadeUpThings made = madeUpThings(3, 6, 3, 1, {.apart = 0.1, .spread = 0.2});
  return made;
}

/// The answers for each view, by the number of its thing.
template <class Answer>
OwnClasses classesOf(const Answer& answer, const LabelConcepts& concepts = chairWords,
                     double minProbability = 0) {
  DescriptorMatrix labels(wordsOfThings.size());
  for (const int instance : threeShapes().instances) labels.append(DescriptorView(answer(instance)));
  return findOwnClasses(wordsOfThings, concepts, labels, threeShapes().instances, threeShapes().shapes, {},
                        minProbability);
}

/// Each shape has an answer of its own; that of the third is not sure.
const std::vector<float>& answerByShape(int instance) {
  return instance < 6 ? surelyMug : instance < 12 ? surelyChair : mugOrWall;
}

TEST(OwnClasses, AreWordsThatAreSureAndThatShapesConfirm) {
  const OwnClasses own = classesOf(answerByShape);
  ASSERT_THAT(own.classes, SizeIs(2));
  EXPECT_EQ(own.classes[0].name, "chair") << "the sum of two labels";
  EXPECT_EQ(own.classes[1].name, "mug");
  for (const SureWord& word : own.classes) {
    EXPECT_EQ(word.objects, 6U);
    EXPECT_EQ(word.views, 18U);
    EXPECT_GE(word.recognized, 5U);
    EXPECT_LT(word.chance, 0.05);
  }
  EXPECT_NEAR(own.classes[0].probability, 0.85, 1e-6);
  EXPECT_THAT(own.leftOut, IsEmpty());
  EXPECT_EQ(own.unsure, 6U);
  for (std::size_t i = 0; i < own.classOf.size(); ++i)
    EXPECT_EQ(own.classOf[i], threeShapes().classes[i] == 0 ? 1 : threeShapes().classes[i] == 1 ? 0 : -1);
  const TargetClasses targets = targetClassesOf(own, wordsOfThings);
  EXPECT_THAT(targets.classes[0].labels, testing::UnorderedElementsAre("folding chair", "rocking chair"));
  EXPECT_EQ(targets.classOf("rocking chair"), 0);
  EXPECT_EQ(targets.classOf("mug"), 1);
}

TEST(OwnClasses, NeedTwoWordsToCompare) {
  const OwnClasses own = classesOf(answerByShape, {});
  EXPECT_THAT(own.classes, IsEmpty()) << "no chair is a folding chair more than anything else";
  ASSERT_THAT(own.leftOut, SizeIs(1));
  EXPECT_EQ(own.leftOut[0].chance, 1);
  EXPECT_EQ(own.unsure, 12U);
  EXPECT_THAT(classesOf(answerByShape, chairWords, 0.84).leftOut, SizeIs(1)) << "mugs are only sure by .8";
}

TEST(OwnClasses, AreNoneWhereShapesDoNotAgree) {
  const OwnClasses own = classesOf([](int instance) { return instance % 2 == 0 ? surelyMug : surelyChair; });
  EXPECT_THAT(own.classes, IsEmpty());
  EXPECT_THAT(own.leftOut, SizeIs(2));
  EXPECT_THAT(own.classOf, Each(-1));
}

TEST(OwnClasses, AreOfSeveralObjectsEach) {
  const std::vector<float> wall{0, 0, 0, .1F, .9F};
  const OwnClasses own =
      classesOf([&](int instance) { return instance == 17 ? wall : answerByShape(instance); });
  EXPECT_THAT(own.classes, SizeIs(2));
  ASSERT_THAT(own.leftOut, SizeIs(1));
  EXPECT_EQ(own.leftOut[0].name, "wall");
  EXPECT_EQ(leftOutOf(own), "5 objects have no sure word; too rare, one object each: wall");
}

TEST(OwnClasses, RefuseWhatDoesNotBelongTogether) {
  const DescriptorMatrix labels(wordsOfThings.size());
  EXPECT_THAT([&] { findOwnClasses(wordsOfThings, {}, labels, {1}, threeShapes().shapes, {}); },
              FailsWith(ErrorCode::mismatch));
  const OwnClasses none = findOwnClasses(wordsOfThings, {}, labels, {}, threeShapes().shapes, {});
  EXPECT_THAT(none.classes, IsEmpty());
}

}  // namespace
}  // namespace estancia::test
