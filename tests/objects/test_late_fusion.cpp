// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/late_fusion.hpp"
#include "estancia/objects/training.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using Source = FusedAnswer::Source;
using test::FailsWith;

/// Words mug and bowl, whose held-out shapes are mostly right; can, which cannot be held out.
ObjectModel model() {
  test::MadeUpThings things = test::madeUpThings(3, 4, 6, 1);
  for (std::size_t i = 0; i < things.classes.size(); ++i)
    if (things.classes[i] == 2 && (things.instances[i] != 8 || i % 6 > 1)) things.classes[i] = -1;
  ClassifierOptions options;
  options.c = 3;
  options.gamma = 1;
  return trainObjectModel(
      {targetClassesOf({"mug", "bowl", "can"}), {}, things.shapes, things.classes, things.instances, "", {}},
      options);
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
}

TEST_F(LateFusion, OtherWordsAreRefused) {
  image_ = {0.5F, 0.5F};
  EXPECT_THAT([&] { fused(); }, FailsWith(ErrorCode::mismatch));
  image_ = {0.5F, NAN, 0.1F};
  EXPECT_THAT([&] { fused(); }, FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
