// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/words/installed_words.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::rows;
using testing::ElementsAre;
using testing::FloatNear;

TargetClasses read(const std::string& toml) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "classes.toml", toml);
  return readTargetClasses(scratch / "classes.toml");
}

TargetClasses named(const std::vector<std::vector<std::string>>& labels) {
  TargetClasses targets;
  for (const auto& of : labels) targets.classes.push_back({of.front(), of, {of.front()}});
  return targets;
}

const Vocabulary& kitchen() {
  static const Vocabulary labels(
      {"n03063599 coffee mug", "cup", "soup bowl", "mixing bowl", "carton", "cat"});
  return labels;
}

TEST(TargetClasses, IsReadInTheOrderOfItsFile) {
  const TargetClasses targets = read(R"(
[classes.mug]
labels = ["coffee mug", "cup"]
categories = ["fatmug", "mug"]
[classes.bowl]
[classes."beer can"]
labels = ["pop bottle"]
)");
  EXPECT_THAT(targets.names(), ElementsAre("mug", "bowl", "beer can"));
  EXPECT_THAT(targets.classes[0].labels, ElementsAre("coffee mug", "cup"));
  EXPECT_THAT(targets.classes[1].labels, ElementsAre("bowl"));
  EXPECT_THAT(targets.classes[2].categories, ElementsAre("beer can"));
  EXPECT_EQ(targets.classOf("fatmug"), 0);
  EXPECT_EQ(targets.classOf("bowl"), 1);
  EXPECT_EQ(targets.classOf("plate"), -1);
}

TEST(TargetClasses, BadFilesAreRefusedByLine) {
  for (const char* toml :
       {"", "[classes]\n", "classes = 3\n", "[classes]\nmug = 3\n", "[classes.mug]\nlabel = [\"cup\"]\n",
        "[classes.mug]\nlabels = []\n", "[classes.mug]\nlabels = [\"\"]\n", "[classes.mug]\nlabels = [7]\n",
        "[classes.\"a\\u0007b\"]\n", "[classes.mug\n"})
    EXPECT_THAT([&] { read(toml); }, FailsWith(ErrorCode::malformedFile)) << toml;
  EXPECT_THAT([] { read("[classes.mug]\n[classes.cup]\ncategories = [\"a\", \"mug\"]\n"); },
              FailsWith(ErrorCode::malformedFile, "classes.toml:2", "\"cup\""));
  EXPECT_THAT([] { readTargetClasses("nowhere.toml"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(TargetClasses, CategoriesAreWordsByTheirOwnNames) {
  const TargetClasses targets = targetClassesOf({"mug", "can", "mug"});
  EXPECT_THAT(targets.names(), ElementsAre("mug", "can"));
  EXPECT_EQ(targets.classOf("can"), 1);
  EXPECT_THAT([] { targetClassesOf({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { targetClassesOf({"mug", ""}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(VocabularyMapping, AddsUpTheLabelsOfAClass) {
  const ClassProbabilities said = restrictTo(
      named({{"mug", "coffee mug", "cup"}, {"bowl"}}), kitchen(),
      rows({{0.1F, 0.1F, 0.1F, 0.1F, 0.2F, 0.4F}, {0.2F, 0.1F, 0.1F, 0, 0, 0.6F}, {0, 0, 0, 0, 0.3F, 0.7F}}));
  EXPECT_THAT(said.probabilities.row(0), ElementsAre(FloatNear(0.5F, 1e-6F), FloatNear(0.5F, 1e-6F)));
  EXPECT_THAT(said.probabilities.row(1), ElementsAre(FloatNear(0.75F, 1e-6F), FloatNear(0.25F, 1e-6F)));
  EXPECT_THAT(said.probabilities.row(2), ElementsAre(0, 0));
  EXPECT_THAT(said.coverage, ElementsAre(FloatNear(0.4F, 1e-6F), FloatNear(0.4F, 1e-6F), 0));
}

TEST(VocabularyMapping, LabelsCountForTheFirstClassAlone) {
  const Vocabulary labels({"cup, mug", "cup of tea"});
  const ClassProbabilities said =
      restrictTo(named({{"mug"}, {"cup", "cup", "cup of tea"}}), labels, rows({{0.6F, 0.2F}}));
  EXPECT_THAT(said.probabilities.row(0), ElementsAre(FloatNear(0.75F, 1e-6F), FloatNear(0.25F, 1e-6F)));
  EXPECT_THAT(
      [&] {
        restrictTo(named({{"mug"}, {"cup"}}), labels, rows({{0.6F, 0.2F}}));
      },
      FailsWith(ErrorCode::invalidInput));
}

TEST(VocabularyMapping, UnknownClassesAreAllNamedWithNearSpellings) {
  const DescriptorMatrix one = rows({std::vector<float>(6, 0.1F)});
  const auto refusal = [&](const TargetClasses& targets) {
    return test::caught([&] { restrictTo(targets, kitchen(), one); });
  };
  EXPECT_THAT(refusal(named({{"mug"}, {"cartin"}, {"zeppelin"}})),
              FailsWith(ErrorCode::unknownName, "cartin (is it carton?)"));
  EXPECT_THAT(refusal(named({{"zeppelin"}, {"ocarina"}})), FailsWith(ErrorCode::unknownName));
  EXPECT_FALSE(
      refusal(named({{"mug", "zeppelin", "coffee mug"}})).code.has_value());  // one label of a word is enough
}

const Vocabulary& household() {
  static const Vocabulary labels({"studio couch, day bed", "folding chair", "golden retriever", "beagle",
                                  "coffee mug", "refrigerator", "crane", "crane"});
  return labels;
}

TEST(WithLabelKinds, ClassesWithoutALabelGetTheKindsOfIt) {
  std::vector<std::string> told;
  const TargetClasses targets =
      withLabelKinds(named({{"sofa"}, {"mug", "cup"}, {"dog"}}), household(), installedWordGraph, &told);
  EXPECT_THAT(targets.classes[0].labels, ElementsAre("sofa", "studio couch"));
  EXPECT_THAT(targets.classes[1].labels, ElementsAre("mug", "cup")) << "a label has the name";
  EXPECT_THAT(targets.classes[2].labels, ElementsAre("dog", "golden retriever", "beagle"));
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0], "sofa: the labeler has no label of that name; taken: studio couch (a kind of sofa)");
  EXPECT_EQ(withLabelKinds(targets, household(), installedWordGraph).classes[0].labels.size(), 2U)
      << "what is understood stays so";
}

TEST(WithLabelKinds, RelatedLabelsAreSuggestedOnly) {
  const auto refusal = [](WordGraphSource source) {
    return test::caught([&] { withLabelKinds(named({{"mug"}, {"fridge"}}), household(), source); });
  };
  EXPECT_THAT(refusal(installedWordGraph), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(refusal(nullptr), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(test::caught([] { withLabelKinds(named({{"bird"}}), household(), installedWordGraph); }),
              FailsWith(ErrorCode::unknownName))
      << "the name of the bird is that of a machine, too";
}

TEST(VocabularyMapping, WhatIsNoProbabilityIsRefused) {
  const TargetClasses targets = named({{"mug"}, {"cat"}});
  const std::pair<std::vector<float>, ErrorCode> cases[] = {{{0.1F, 0.2F}, ErrorCode::mismatch},
                                                            {{NAN, 0, 0, 0, 0, 0}, ErrorCode::labelerFailure},
                                                            {{2, 0, 0, 0, 0, 0}, ErrorCode::labelerFailure}};
  for (const auto& each : cases)
    EXPECT_THAT([&] { restrictTo(targets, kitchen(), rows({each.first})); }, FailsWith(each.second));
  EXPECT_EQ(restrictTo(targets, kitchen(), DescriptorMatrix(6)).probabilities.size(), 0U);
}

TEST(Prior, IsTheMeanOfWhatIsSaid) {
  const ClassProbabilities said{rows({{0.8F, 0.2F}, {0.6F, 0.4F}, {0, 0}}), {1, 1, 0}};
  EXPECT_THAT(priorOf(said), ElementsAre(FloatNear(0.7F, 1e-6F), FloatNear(0.3F, 1e-6F)));
  EXPECT_THAT(priorOf({rows({{0, 0}}), {0}}), ElementsAre(0.5F, 0.5F));
  EXPECT_THAT(priorOf({DescriptorMatrix(2), {}}), ElementsAre(0.5F, 0.5F));
}

TEST(Prior, CorrectionUndoesWhatTheLabelerLikes) {
  // Its answer is "bowl" nearly always, a little less for mugs.
  const ClassProbabilities said{rows({{0.1F, 0.9F}, {0.3F, 0.7F}, {0, 0}}), {1, 1, 0}};
  const ClassProbabilities even = corrected(said, priorOf(said));
  EXPECT_EQ(test::best(even.probabilities.row(0)), 1);
  EXPECT_EQ(test::best(even.probabilities.row(1)), 0);
  EXPECT_NEAR(even.probabilities.row(1)[0], 0.3 / 0.2 / (0.3 / 0.2 + 0.7 / 0.8), 1e-6);
  EXPECT_THAT(even.probabilities.row(2), ElementsAre(0, 0));
  EXPECT_EQ(even.coverage, said.coverage);
  const std::vector<float> flat{0.5F, 0.5F};
  EXPECT_THAT(corrected(said, flat).probabilities.row(1),
              ElementsAre(FloatNear(0.3F, 1e-6F), FloatNear(0.7F, 1e-6F)));
}

TEST(Prior, NeverSaidIsNotImpossible) {
  const ClassProbabilities said{rows({{0.0F, 1.0F}, {0.5F, 0.5F}}), {1, 1}};
  const std::vector<float> prior{0, 1}, other{0.2F, 0.3F, 0.5F}, odd{NAN, 1};
  const ClassProbabilities even = corrected(said, prior);
  EXPECT_THAT(even.probabilities.row(0), ElementsAre(0, 1));
  EXPECT_NEAR(even.probabilities.row(1)[0] + even.probabilities.row(1)[1], 1, 1e-6);
  EXPECT_THAT([&] { corrected(said, other); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { corrected(said, odd); }, FailsWith(ErrorCode::labelerFailure));
}

}  // namespace
}  // namespace estancia
