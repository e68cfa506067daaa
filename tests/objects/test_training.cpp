// Views and words become what a model is learned from.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/objects/collect.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

using ::testing::ElementsAre;
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

const TargetClasses targets{{{"mug", {"coffee mug"}, {"mug", "cup"}}, {"bottle", {"bottle"}, {"bottle"}}}};

class Training : public testing::Test {
 protected:
  TrainingSet gather(std::vector<LabeledViews> sources, TrainingOptions options = {},
                     const TargetClasses& of = targets) {
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
  EXPECT_THAT([&] { gather(sources, {.split = "tset"}); }, FailsWith(ErrorCode::unknownName));
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

}  // namespace
}  // namespace estancia::test
