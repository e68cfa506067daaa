#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/target_classes.hpp"
#include "made_up.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::errorOf;
using test::rows;
using testing::AllOf;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;

TargetClasses read(const std::string& toml) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "study.toml", toml);
  return TargetClasses::fromFile(scratch / "study.toml");
}

TargetClasses named(const std::vector<std::vector<std::string>>& labels) {
  TargetClasses study;
  for (const auto& of : labels) study.words.push_back({of.front(), of, {of.front()}});
  return study;
}

const Vocabulary& kitchen() {
  static const Vocabulary labels(
      {"n03063599 coffee mug", "cup", "soup bowl", "mixing bowl", "carton", "cat"});
  return labels;
}

TEST(TargetClasses, IsReadInTheOrderOfItsFile) {
  const TargetClasses study = read(R"(
[words.mug]
labels = ["coffee mug", "cup"]
categories = ["fatmug", "mug"]
[words.bowl]
[words."beer can"]
labels = ["pop bottle"]
)");
  EXPECT_THAT(study.names(), ElementsAre("mug", "bowl", "beer can"));
  EXPECT_THAT(study.words[0].labels, ElementsAre("coffee mug", "cup"));
  EXPECT_THAT(study.words[1].labels, ElementsAre("bowl"));
  EXPECT_THAT(study.words[2].categories, ElementsAre("beer can"));
  EXPECT_EQ(study.wordOf("fatmug"), 0);
  EXPECT_EQ(study.wordOf("bowl"), 1);
  EXPECT_EQ(study.wordOf("plate"), -1);
}

TEST(TargetClasses, BadFilesAreRefusedByLine) {
  const auto refusal = [](const std::string& toml) { return errorOf([&] { read(toml); }); };
  EXPECT_THAT(refusal(""), HasSubstr("the key `words` is missing"));
  EXPECT_THAT(refusal("[words]\n"), HasSubstr("study.toml:1: a study needs at least one word"));
  EXPECT_THAT(refusal("words = 3\n"), HasSubstr("study.toml:1: `words` must be a table"));
  EXPECT_THAT(refusal("[words]\nmug = 3\n"), HasSubstr("study.toml:2: `words.mug` must be a table"));
  EXPECT_THAT(refusal("[words.mug]\nlabel = [\"cup\"]\n"),
              HasSubstr("study.toml:2: unknown key `label`; known keys are labels, categories"));
  EXPECT_THAT(refusal("[words.mug]\nlabels = []\n"), HasSubstr("study.toml:2: `labels` is empty"));
  EXPECT_THAT(refusal("[words.mug]\nlabels = [\"\"]\n"), HasSubstr("study.toml:1: \"mug\" has a label"));
  EXPECT_THAT(refusal("[words.mug]\nlabels = [7]\n"), HasSubstr("must be a text"));
  EXPECT_THAT(refusal("[words.\"a\\u0007b\"]\n"), HasSubstr("control characters"));
  EXPECT_THAT(refusal("[words.mug]\n[words.cup]\ncategories = [\"a\", \"mug\"]\n"),
              HasSubstr("study.toml:2: the category \"mug\" belongs to both \"mug\" and \"cup\""));
  EXPECT_THAT(refusal("[words.mug\n"), HasSubstr("study.toml:1: "));
  EXPECT_NE(errorOf([] { TargetClasses::fromFile("nowhere.toml"); }), "");
}

TEST(TargetClasses, CategoriesAreWordsByTheirOwnNames) {
  const TargetClasses study = TargetClasses::ofCategories({"mug", "can", "mug"});
  EXPECT_THAT(study.names(), ElementsAre("mug", "can"));
  EXPECT_EQ(study.wordOf("can"), 1);
  EXPECT_NE(errorOf([] { TargetClasses::ofCategories({}); }), "");
  EXPECT_NE(errorOf([] { TargetClasses::ofCategories({"mug", ""}); }), "");
}

TEST(VocabularyMapping, AddsUpTheLabelsOfAWord) {
  const ClassProbabilities said = restrictTo(
      named({{"mug", "coffee mug", "cup"}, {"bowl"}}), kitchen(),
      rows({{0.1F, 0.1F, 0.1F, 0.1F, 0.2F, 0.4F}, {0.2F, 0.1F, 0.1F, 0, 0, 0.6F}, {0, 0, 0, 0, 0.3F, 0.7F}}));
  EXPECT_THAT(said.shares.row(0), ElementsAre(FloatNear(0.5F, 1e-6F), FloatNear(0.5F, 1e-6F)));
  EXPECT_THAT(said.shares.row(1), ElementsAre(FloatNear(0.75F, 1e-6F), FloatNear(0.25F, 1e-6F)));
  EXPECT_THAT(said.shares.row(2), ElementsAre(0, 0));
  EXPECT_THAT(said.mass, ElementsAre(FloatNear(0.4F, 1e-6F), FloatNear(0.4F, 1e-6F), 0));
}

TEST(VocabularyMapping, LabelsCountForTheFirstWordAlone) {
  const Vocabulary labels({"cup, mug", "cup of tea"});
  const ClassProbabilities said =
      restrictTo(named({{"mug"}, {"cup", "cup", "cup of tea"}}), labels, rows({{0.6F, 0.2F}}));
  EXPECT_THAT(said.shares.row(0), ElementsAre(FloatNear(0.75F, 1e-6F), FloatNear(0.25F, 1e-6F)));
  EXPECT_THAT(errorOf([&] {
                restrictTo(named({{"mug"}, {"cup"}}), labels, rows({{0.6F, 0.2F}}));
              }),
              HasSubstr("no label of their own: cup (they count for mug)"));
}

/// Several models together say more than one whole.
TEST(VocabularyMapping, MassIsAShareOfAllThatIsSaid) {
  const ClassProbabilities said =
      restrictTo(named({{"mug"}, {"bowl"}}), Vocabulary({"mug", "bowl", "cat"}), rows({{0.9F, 0.3F, 0.8F}}));
  EXPECT_NEAR(said.mass[0], 0.6, 1e-6);
}

TEST(VocabularyMapping, UnknownWordsAreAllNamedWithNearSpellings) {
  const DescriptorMatrix one = rows({std::vector<float>(6, 0.1F)});
  const auto refusal = [&](const TargetClasses& study) {
    return errorOf([&] { restrictTo(study, kitchen(), one); });
  };
  EXPECT_THAT(refusal(named({{"mug"}, {"cartin"}, {"zeppelin"}})),
              AllOf(HasSubstr("no label for 2 of the study's 3 words"), HasSubstr("cartin (is it carton?)"),
                    HasSubstr("zeppelin;")));
  EXPECT_THAT(refusal(named({{"zeppelin"}, {"ocarina"}})),
              HasSubstr("knows none of the study's words: zeppelin, ocarina; give them other labels"));
  EXPECT_EQ(refusal(named({{"mug", "zeppelin", "coffee mug"}})), "");  // one label of a word is enough
}

TEST(VocabularyMapping, LabelsThatAreUnknownBesideOthersAreTold) {
  const TargetClasses study = named({{"mug", "cofee mug", "zeppelin"}, {"bowl", "soup bowl"}, {"cartin"}});
  EXPECT_THAT(unknownLabels(study, kitchen()),
              ElementsAre("mug: the labeler has no label \"cofee mug\" (is it coffee mug?)",
                          "mug: the labeler has no label \"zeppelin\""))
      << "a word without any label is an error";
}

TEST(VocabularyMapping, WhatIsNoProbabilityIsRefused) {
  const TargetClasses study = named({{"mug"}, {"cat"}});
  EXPECT_NE(errorOf([&] { restrictTo(study, kitchen(), rows({{0.1F, 0.2F}})); }), "");
  EXPECT_NE(errorOf([&] { restrictTo(study, kitchen(), rows({{NAN, 0, 0, 0, 0, 0}})); }), "");
  EXPECT_NE(errorOf([&] { restrictTo(study, kitchen(), rows({{2, 0, 0, 0, 0, 0}})); }), "");
  EXPECT_EQ(restrictTo(study, kitchen(), DescriptorMatrix(6)).shares.size(), 0U);
}

TEST(Prior, IsTheMeanOfWhatIsSaid) {
  const ClassProbabilities said{rows({{0.8F, 0.2F}, {0.6F, 0.4F}, {0, 0}}), {1, 1, 0}};
  EXPECT_THAT(priorOf(said), ElementsAre(FloatNear(0.7F, 1e-6F), FloatNear(0.3F, 1e-6F)));
  EXPECT_THAT(priorOf({rows({{0, 0}}), {0}}), ElementsAre(0.5F, 0.5F));
  EXPECT_THAT(priorOf({DescriptorMatrix(2), {}}), ElementsAre(0.5F, 0.5F));
}

TEST(Prior, CorrectionUndoesWhatTheLabelerLikes) {
  // It says "bowl" nearly always, and a little less of mugs.
  const ClassProbabilities said{rows({{0.1F, 0.9F}, {0.3F, 0.7F}, {0, 0}}), {1, 1, 0}};
  const ClassProbabilities even = corrected(said, priorOf(said));
  EXPECT_EQ(test::best(even.shares.row(0)), 1);
  EXPECT_EQ(test::best(even.shares.row(1)), 0);
  EXPECT_NEAR(even.shares.row(1)[0], 0.3 / 0.2 / (0.3 / 0.2 + 0.7 / 0.8), 1e-6);
  EXPECT_THAT(even.shares.row(2), ElementsAre(0, 0));
  EXPECT_EQ(even.mass, said.mass);
  const std::vector<float> flat{0.5F, 0.5F};
  EXPECT_THAT(corrected(said, flat).shares.row(1),
              ElementsAre(FloatNear(0.3F, 1e-6F), FloatNear(0.7F, 1e-6F)));
}

TEST(Prior, NeverSaidIsNotImpossible) {
  const ClassProbabilities said{rows({{0.0F, 1.0F}, {0.5F, 0.5F}}), {1, 1}};
  const std::vector<float> prior{0, 1}, other{0.2F, 0.3F, 0.5F}, odd{NAN, 1};
  const ClassProbabilities even = corrected(said, prior);
  EXPECT_THAT(even.shares.row(0), ElementsAre(0, 1));
  EXPECT_NEAR(even.shares.row(1)[0] + even.shares.row(1)[1], 1, 1e-6);
  EXPECT_NE(errorOf([&] { corrected(said, other); }), "");
  EXPECT_NE(errorOf([&] { corrected(said, odd); }), "");
}

}  // namespace
}  // namespace estancia
