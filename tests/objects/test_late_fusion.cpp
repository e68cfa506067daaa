#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/late_fusion.hpp"
#include "made_up.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Source = FusedAnswer::Source;
using test::errorOf;
using testing::HasSubstr;

/// Words mug and bowl, whose held-out shapes are mostly right; can, which cannot be held out.
ObjectModel model() {
  test::MadeUpThings things = test::madeUpThings(3, 4, 6, 1);
  for (std::size_t i = 0; i < things.words.size(); ++i)
    if (things.words[i] == 2 && (things.instances[i] != 8 || i % 6 > 1)) things.words[i] = -1;
  Progress silent;
  ClassifierOptions options;
  options.c = 3;
  options.gamma = 1;
  return ObjectModel::train({TargetClasses::ofCategories({"mug", "bowl", "can"}),
                             {},
                             things.shapes,
                             things.words,
                             things.instances,
                             "",
                             {}},
                            options, silent);
}

class PlaceFilter : public testing::Test {
 protected:
  static const ObjectModel& learned() {
    static const ObjectModel once = model();
    return once;
  }
  FusedAnswer believed() {
    evidence_.seen = seen_;
    evidence_.shape = shape_;
    return fuseAnswers(learned(), evidence_);
  }
  std::vector<float> seen_{0.8F, 0.1F, 0.1F}, shape_{0.7F, 0.2F, 0.1F};
  ObjectEvidence evidence_{{}, 0.5F, 0.6, {}, false};
};

TEST_F(PlaceFilter, InBothWhereTheyAgree) {
  const FusedAnswer belief = believed();
  EXPECT_EQ(belief.source, Source::both);
  EXPECT_EQ(belief.word, 0);
  EXPECT_NEAR(belief.probability, 0.8, 1e-6);
  EXPECT_EQ(belief.why, "image and shape agree on mug, 80 % and 70 %");
}

TEST_F(PlaceFilter, InNothingFlat) {
  evidence_.flat = true;
  const FusedAnswer belief = believed();
  EXPECT_EQ(belief.source, Source::none);
  EXPECT_EQ(belief.word, -1);
  EXPECT_EQ(belief.probability, 0);
  EXPECT_THAT(belief.why,
              HasSubstr("it is flat: an image of something, or a single face; the image says mug 80 %"));
}

TEST_F(PlaceFilter, InTheShapeWhereTheImageTellsNothing) {
  shape_ = {0.1F, 0.3F, 0.6F};
  const auto expectShape = [&](const std::string& why) {
    const FusedAnswer belief = believed();
    EXPECT_EQ(belief.source, Source::shape);
    EXPECT_EQ(belief.word, 2);
    EXPECT_THAT(belief.why, HasSubstr(why));
    EXPECT_THAT(belief.why, HasSubstr("; the shape says can 60 %"));
  };
  evidence_.brightness = 0.04;
  expectShape("too dark to be seen, 4 % of white");
  evidence_.brightness = NAN;
  expectShape("too dark");
  evidence_.brightness = 0.5;
  evidence_.mass = 0.004F;
  expectShape("the study's words are 0.4 % of its answer");
  seen_ = {0, 0, 0};
  expectShape("says nothing of the study's words");
  seen_.clear();
  expectShape("no image was asked about");
}

TEST_F(PlaceFilter, InTheImageWhereThereIsNoShape) {
  shape_.clear();
  FusedAnswer belief = believed();
  EXPECT_EQ(belief.source, Source::seen);
  EXPECT_EQ(belief.word, 0);
  EXPECT_EQ(belief.why, "its shape could not be described; the image says mug 80 %");
  evidence_.brightness = 0;
  belief = believed();
  EXPECT_EQ(belief.source, Source::none);
  EXPECT_EQ(belief.word, -1);
  EXPECT_THAT(belief.why, HasSubstr("too dark"));
  seen_.clear();
  EXPECT_EQ(believed().source, Source::none);
}

TEST_F(PlaceFilter, InWhatIsMoreLikelyWhereTheyDiffer) {
  ASSERT_GT(learned().agreement()[1], 0.9F);
  shape_ = {0.4F, 0.6F, 0};
  FusedAnswer belief = believed();
  EXPECT_EQ(belief.source, Source::shape);
  EXPECT_EQ(belief.word, 1);
  EXPECT_NEAR(belief.probability, 0.6, 1e-6);
  EXPECT_THAT(belief.why,
              HasSubstr(fmt::format("the image says mug 80 %, the shape bowl 60 %: such shapes were "
                                    "right in {:.0f} % of what was held out, which makes the shape",
                                    100 * learned().agreement()[1])));
  shape_ = {0.3F, 0.35F, 0.34F};
  seen_ = {0.99F, 0.01F, 0};
  belief = believed();
  EXPECT_EQ(belief.source, Source::seen);
  EXPECT_EQ(belief.word, 0);
  EXPECT_THAT(belief.why, HasSubstr("which makes the image more likely"));
}

TEST_F(PlaceFilter, InShapesThatWereNeverTestedByTheirProbabilityAlone) {
  ASSERT_EQ(learned().agreement()[2], -1);
  shape_ = {0.2F, 0.1F, 0.7F};
  FusedAnswer belief = believed();
  EXPECT_EQ(belief.source, Source::seen);
  EXPECT_THAT(belief.why, HasSubstr("how often such shapes are right is not known"));
  seen_ = {0.6F, 0.4F, 0};
  belief = believed();
  EXPECT_EQ(belief.source, Source::shape);
  EXPECT_EQ(belief.word, 2);
}

TEST_F(PlaceFilter, OtherWordsAreRefused) {
  seen_ = {0.5F, 0.5F};
  EXPECT_NE(errorOf([&] { believed(); }), "");
  seen_ = {0.5F, NAN, 0.1F};
  EXPECT_NE(errorOf([&] { believed(); }), "");
}

}  // namespace
}  // namespace estancia
