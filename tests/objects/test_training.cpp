// What object models learn from: the classes of their words, and the views that have names.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/words/installed_words.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

using ::testing::ElementsAre;
using testing::ElementsAre;
using testing::FloatNear;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Rods of different lengths; those of fewer than two points cannot be described.
class MadeUpViews : public ObjectViews {
 public:
  explicit MadeUpViews(std::vector<ObjectView> views, std::size_t points = 50)
      : views_(std::move(views)), points_(points) {}
  std::string name() const override { return "made up"; }
  std::size_t size() const override { return views_.size(); }
  const ObjectView& view(std::size_t i) const override { return views_[i]; }
  PointCloud cloud(std::size_t i) const override {
    PointCloud cloud;
    const std::size_t points = views_[i].name == "broken" ? 0 : points_;
    for (std::size_t k = 0; k < points; ++k)
      cloud.points.emplace_back(0.01F * static_cast<float>(k), 0.02F * static_cast<float>((i + 1) * (k % 3)),
                                1);
    cloud.width = points;
    cloud.height = 1;
    return cloud;
  }
  ObjectImage image(std::size_t /*i*/) const override { return {}; }

 private:
  std::vector<ObjectView> views_;
  std::size_t points_;
};

ObjectView view(const std::string& name, const std::string& instance, const std::string& category = "") {
  return {name, instance, category, "", "", false, false};
}

/// The answers of a labeler that knows three words, for the views that are named.
DescriptorSequence said(const std::vector<std::pair<std::string, std::vector<float>>>& answers,
                        const std::string& model = "labeler 1") {
  DescriptorSequence words{Vocabulary({"coffee mug", "bottle", "wall"}), model, {}, DescriptorMatrix(3)};
  for (const auto& [name, row] : answers) {
    words.frames.push_back({name, {}, {}, ""});
    words.descriptors.append(row);
  }
  return words;
}

const TargetClasses cupsAndBottles{
    {{"mug", {"coffee mug"}, {"mug", "cup"}}, {"bottle", {"bottle"}, {"bottle"}}}};

class Training : public testing::Test {
 protected:
  TrainingSet gather(std::vector<LabeledViews> sources, TrainingOptions options = {},
                     const TargetClasses& of = cupsAndBottles) {
    problems_.clear();
    options.shape.samples = 100;
    return gatherTraining(sources, of, options, Progress::none(), &problems_);
  }
  std::vector<std::string> problems_;
};

TEST_F(Training, NamesComeFromWhatIsSaidOfAThingAltogether) {
  const MadeUpViews views({view("a", "1"), view("b", "1"), view("c", "1"), view("d", "2"), view("e", "2")});
  const auto words = said({{"a", {.8F, .1F, .1F}},
                           {"b", {.8F, .1F, .1F}},
                           {"c", {.2F, .3F, .5F}},
                           {"d", {.1F, .6F, .3F}},
                           {"e", {0, 0, 1}}});
  TrainingOptions options{.pseudoLabels = PseudoLabeling::voted, .correctPrior = false};
  const TrainingSet voted = gather({{&views, words}}, options);
  EXPECT_THAT(voted.training.classes, ElementsAre(0, 0, 0, 1, 1));
  EXPECT_THAT(voted.training.instances, ElementsAre(0, 0, 0, 1, 1));
  EXPECT_THAT(voted.samples, ElementsAre(3, 2));
  EXPECT_THAT(voted.instances, ElementsAre(1, 1));
  EXPECT_EQ(voted.training.labeler, "labeler 1");
  EXPECT_THAT(voted.training.prior, IsEmpty());
  EXPECT_NEAR(voted.coverage, (.9 + .9 + .5 + .7 + 0) / 5, 1e-6);
  options.pseudoLabels = PseudoLabeling::top;
  const TrainingSet top = gather({{&views, words}}, options);
  EXPECT_THAT(top.training.classes, ElementsAre(0, 0, 1, 1, -1));
  EXPECT_EQ(top.rejected, 1U);
  EXPECT_THAT(gather({{&views, words}}).training.prior, SizeIs(2)) << "corrected unless told otherwise";
}

TEST_F(Training, ThingsThatAreSomethingElseGetNoName) {
  const MadeUpViews views({view("a", "1"), view("b", "1"), view("c", "2")});
  const auto words = said({{"a", {.3F, 0, .7F}}, {"b", {.1F, 0, .9F}}, {"c", {0, .1F, .9F}}});
  const auto gathered = gather({{&views, words}}, {.pseudoLabels = PseudoLabeling::top, .minCoverage = 0.15});
  EXPECT_THAT(gathered.training.classes, ElementsAre(0, 0, -1)) << "of thing 1 the mean is 0.2";
  EXPECT_THAT([&] { gather({{&views, words}}, {.minCoverage = 2}); }, FailsWith(ErrorCode::invalidOption));
}

TEST_F(Training, FlatOnesAndThoseAtTheBorderAreLeftOut) {
  std::vector<ObjectView> list{view("a", "1"), view("b", "2"), view("c", "3")};
  list[0].flat = true;
  list[1].atBorder = true;
  const MadeUpViews views(list);
  const auto words = said({{"a", {1, 0, 0}}, {"b", {1, 0, 0}}, {"c", {1, 0, 0}}});
  const auto some = gather({{&views, words}});
  EXPECT_THAT(some.training.classes, ElementsAre(0));
  EXPECT_EQ(some.flat, 1U);
  EXPECT_EQ(some.atBorder, 1U);
  EXPECT_THAT(gather({{&views, words}}, {.allViews = true}).training.classes, SizeIs(3));
}

TEST_F(Training, ViewsWithoutWordsOrShapeAreLeftOut) {
  const MadeUpViews views({view("a", "1"), view("broken", "1"), view("c", "2"), view("d", "2")});
  const auto gathered = gather({{&views, said({{"a", {1, 0, 0}}, {"broken", {1, 0, 0}}, {"d", {0, 1, 0}}})}});
  EXPECT_EQ(gathered.unlabeled, 1U);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_EQ(problems_[0].substr(0, 6), "broken");
  EXPECT_THAT(gathered.training.classes, ElementsAre(0, 1)) << "the answers stay with their views";
  EXPECT_EQ(gathered.training.shapes.frames[1].name, "d");
}

TEST_F(Training, TrueCategoriesAreNames) {
  const MadeUpViews views({view("a", "1", "cup"), view("b", "2", "bottle"), view("c", "3", "table")});
  const auto gathered = gather({{&views, {}}});
  EXPECT_THAT(gathered.training.classes, ElementsAre(0, 1));
  EXPECT_EQ(gathered.unlabeled, 1U);
  EXPECT_EQ(gathered.training.labeler, "");
  const auto checked =
      gather({{&views, said({{"a", {1, 0, 0}}, {"b", {1, 0, 0}}})}}, {.correctPrior = false});
  EXPECT_EQ(checked.comparable, 2U);
  EXPECT_EQ(checked.correct, 1U);
  EXPECT_THAT(categoriesOf(std::vector<LabeledViews>{{&views, {}}}), ElementsAre("bottle", "cup", "table"));
}

TEST_F(Training, OnlyAPartOfTheDataOfSeveralFolders) {
  std::vector<ObjectView> list{view("a", "1", "cup"), view("b", "2", "cup"), view("c", "2", "cup")};
  const MadeUpViews without(list);
  list[1].split = "train";
  list[2].split = "test";
  const MadeUpViews with(list);
  EXPECT_THAT(gather({{&without, {}}, {&with, {}}}, {.split = "test"}).training.classes, SizeIs(1));
  const std::vector<LabeledViews> sources{{&without, {}}, {&with, {}}};
  const std::vector<LabeledViews> whole{{&without, {}}};
  EXPECT_THAT([&] { gather(sources, {.split = "tset"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { gather(whole, {.split = "test"}); }, FailsWith(ErrorCode::unknownName));
  const MadeUpViews monday({view("a", "1")}), tuesday({view("a", "1")});
  const auto words = said({{"a", {1, 0, 0}}});
  EXPECT_THAT(gather({{&monday, words}, {&tuesday, words}}).training.instances, ElementsAre(0, 1));
}

TEST_F(Training, WordsAreFoundAsThoseOfFramesAre) {
  const MadeUpViews views({view("mugs/a.pcd", "1"), view("bottles/b.pcd", "2"), view("c.pcd", "2")});
  const auto words = said({{"a.pcd", {1, 0, 0}}, {"b.pcd", {0, 1, 0}}, {"bottles/c.png", {0, 1, 0}}});
  EXPECT_THAT(gather({{&views, words}}).training.classes, ElementsAre(0, 1, 1));
}

TEST_F(Training, RefusesWhatCannotBeLearnedFrom) {
  const MadeUpViews views({view("a", "1"), view("b", "2")});
  const auto words = said({{"a", {1, 0, 0}}, {"b", {0, 1, 0}}});
  const auto other = said({{"a", {1, 0, 0}}}, "labeler 2"),
             unlike = said({{"a", {0, 0, 1}}, {"b", {0, 0.2F, 0.8F}}});
  using Sources = std::vector<LabeledViews>;
  const std::pair<Sources, ErrorCode> cases[] = {
      {{{&views, said({{"x", {1, 0, 0}}})}}, ErrorCode::insufficientData},
      {{{&views, said({})}}, ErrorCode::insufficientData},
      {{{&views, said({{"a", {0, 0, 1}}})}}, ErrorCode::insufficientData},
      {{{&views, words}, {&views, {}}}, ErrorCode::mismatch},
      {{{&views, words}, {&views, other}}, ErrorCode::mismatch}};
  for (const auto& each : cases) EXPECT_THAT([&] { gather(each.first); }, FailsWith(each.second));
  const Sources known{{&views, words}}, nearlyUnknown{{&views, unlike}};
  const TargetClasses birds{{{"robin", {"robin"}, {"robin"}}, {"wren", {"wren"}, {"wren"}}}};
  EXPECT_THAT([&] { gather(known, {}, birds); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { gather(nearlyUnknown, {.minCoverage = 0.5}); },
              FailsWith(ErrorCode::insufficientData, "\"wall\""))
      << "it names the labeler's own words";
  EXPECT_EQ(gather(nearlyUnknown).rejected, 1U) << "one of two is enough";
}

TEST_F(Training, LabelsMakeTheirOwnClassesOnlyWhereTheyCan) {
  const MadeUpViews views({view("a", "1"), view("b", "2")});
  const auto words = said({{"a", {1, 0, 0}}, {"b", {0, 1, 0}}});
  DescriptorSequence other = words;
  other.vocabulary = Vocabulary({"coffee mug", "bottle", "floor"});
  using Sources = std::vector<LabeledViews>;
  const std::pair<Sources, ErrorCode> cases[] = {{{{&views, words}}, ErrorCode::insufficientData},
                                                 {{{&views, {}}}, ErrorCode::insufficientData},
                                                 {{{&views, words}, {&views, other}}, ErrorCode::mismatch}};
  for (const auto& each : cases) EXPECT_THAT([&] { gather(each.first, {}, {}); }, FailsWith(each.second));
}

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
  const TargetClasses alike = named({{"mug"}, {"cup"}});
  EXPECT_THAT([&] { restrictTo(alike, labels, rows({{0.6F, 0.2F}})); }, FailsWith(ErrorCode::invalidInput));
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

TEST(UnknownLabels, AreToldWhereOthersOfTheClassAreKnown) {
  const TargetClasses targets = named({{"beagle"}, {"refrigerator", "fridge", "icebox"}, {"zeppelin"}});
  for (const WordGraphSource source : {WordGraphSource(nullptr), WordGraphSource(installedWordGraph)}) {
    const std::vector<std::string> told = unknownLabels(targets, household(), source);
    ASSERT_EQ(told.size(), 2U);
    EXPECT_NE(told[0].find("\"fridge\""), std::string::npos);
    EXPECT_NE(told[1].find("\"icebox\""), std::string::npos);
  }
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
}  // namespace estancia::test
