// Models of objects: shapes described, learned from, kept in files, and used.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/training.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::madeUpThings;
using test::MadeUpThings;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::Ge;
using testing::Le;

ObjectTraining trainingOf(const MadeUpThings& things, int words) {
  return {test::madeUpStudy(words), {}, things.shapes, things.classes, things.instances, "a labeler", {}};
}

ObjectModel learned(const ObjectTraining& training, const std::string& type = "svm-rbf", int threads = 0) {
  ClassifierOptions options;
  options.type = type;
  options.c = 3;
  options.trees = 20;
  options.threads = threads;
  return trainObjectModel(training, options);
}

TEST(ObjectModel, NamesNewViewsOfKnownWords) {
  const ObjectModel model = learned(trainingOf(madeUpThings(4, 3, 8, 1), 4));
  const MadeUpThings asked = madeUpThings(4, 3, 20, 2);
  const DescriptorMatrix p = model.predict(asked.shapes);
  EXPECT_GT(test::shareRight(p, asked.classes), 0.95);
  for (std::size_t i = 0; i < p.size(); ++i) {
    double sum = 0;
    for (const float v : p.row(i)) sum += v;
    EXPECT_NEAR(sum, 1, 1e-5);
  }
  EXPECT_THAT(model.targets().names(), ElementsAre("word 0", "word 1", "word 2", "word 3"));
  EXPECT_EQ(model.labeler(), "a labeler");
  EXPECT_EQ(model.choice().substr(0, 3), "C 3");
  EXPECT_THAT(model.heldOutAccuracy(), AllOf(testing::SizeIs(4), Each(Ge(0.8F)), Each(Le(1.0F))));
}

TEST(ObjectModel, SamplesWithoutWordAndWordsWithoutSamplesAreLeftOut) {
  const MadeUpThings things = madeUpThings(3, 3, 8, 1);
  ObjectTraining training = trainingOf(things, 5);
  for (int& word : training.classes)
    if (word == 1) word = -1;
  const ObjectModel model = learned(training);
  const DescriptorMatrix p = model.predict(things.shapes);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (const std::size_t never : {1, 3, 4}) EXPECT_EQ(p.row(i)[never], 0);
  EXPECT_GT(model.heldOutAccuracy()[0], 0.8F);
  for (const std::size_t never : {1, 3, 4}) EXPECT_EQ(model.heldOutAccuracy()[never], -1);
}

/// Names that have nothing to do with the shapes are not found in shapes that were held out: views of one
/// thing, which are alike, do not answer for each other.
TEST(ObjectModel, AgreementIsOfOtherInstances) {
  const int words = 3, perWord = 8, views = 6;
  MadeUpThings things = madeUpThings(words * perWord, 1, views, 1, {24, 0.3, 0.1});
  for (std::size_t i = 0; i < things.classes.size(); ++i) things.classes[i] = things.instances[i] % words;
  const ObjectModel model = learned(trainingOf(things, words));
  EXPECT_GT(test::shareRight(model.predict(things.shapes), things.classes), 0.95);  // learned by heart
  double sum = 0;
  for (const float share : model.heldOutAccuracy()) sum += share;
  EXPECT_LT(sum / words, 0.65);
}

/// All that was collected is one thing, or a view of two: no more can be learned, but that much.
TEST(ObjectModel, LearnsFromVeryLittle) {
  MadeUpThings one = madeUpThings(2, 1, 8, 1);
  std::ranges::fill(one.instances, 3);
  EXPECT_GT(test::shareRight(learned(trainingOf(one, 2)).predict(one.shapes), one.classes), 0.8);
  const MadeUpThings two = madeUpThings(2, 1, 1, 1);
  const DescriptorMatrix p = learned(trainingOf(two, 2)).predict(two.shapes);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(p.row(i)[0] + p.row(i)[1], 1, 1e-5);
}

/// Too few views to part: the shapes' accuracy is unknown, which is reported.
TEST(ObjectModel, WhatCannotBeHeldOutIsUnknown) {
  const MadeUpThings things = madeUpThings(3, 1, 2, 1);
  EXPECT_THAT(learned(trainingOf(things, 3)).heldOutAccuracy(), Each(-1));
}

TEST(ObjectModel, BadTrainingDataAndOtherShapesAreRefused) {
  const MadeUpThings things = madeUpThings(3, 2, 5, 1);
  const ObjectTraining sound = trainingOf(things, 3);
  const std::pair<ErrorCode, void (*)(ObjectTraining&)> changes[] = {
      {ErrorCode::insufficientData, [](ObjectTraining& t) { std::ranges::fill(t.classes, 2); }},
      {ErrorCode::insufficientData, [](ObjectTraining& t) { std::ranges::fill(t.classes, -1); }},
      {ErrorCode::insufficientData,
       [](ObjectTraining& t) {
         t = {t.targets, {}, {t.shapes.parts, {}, DescriptorMatrix(24)}, {}, {}, "", {}};
       }},
      {ErrorCode::mismatch, [](ObjectTraining& t) { t.instances.pop_back(); }},
      {ErrorCode::invalidInput, [](ObjectTraining& t) { t.classes[4] = 3; }},
      {ErrorCode::invalidInput,
       [](ObjectTraining& t) {
         t.prior = {0.5F, 0.5F};
       }},
      {ErrorCode::invalidInput,
       [](ObjectTraining& t) {
         t.prior = {0.5F, NAN, 0.5F};
       }},
      {ErrorCode::invalidInput,
       [](ObjectTraining& t) {
         DescriptorMatrix values(24);
         for (std::size_t i = 0; i < t.shapes.values.size(); ++i) {
           std::vector<float> row(t.shapes.values.row(i).begin(), t.shapes.values.row(i).end());
           if (i == 7) row[5] = NAN;
           values.append(row);
         }
         t.shapes.values = values;
       }},
      {ErrorCode::invalidInput, [](ObjectTraining& t) { t.targets = {}; }}};
  for (const auto& each : changes) {
    ObjectTraining changed = sound;
    each.second(changed);
    EXPECT_THAT([&] { learned(changed); }, FailsWith(each.first));
  }
  const ObjectModel model = learned(sound);
  Features other = things.shapes;
  other.parts[0].identity = "esf of another number of samples";
  EXPECT_THAT([&] { model.predict(other); }, FailsWith(ErrorCode::mismatch));
}

// ---- files

ObjectTraining small() {
  ObjectTraining training = trainingOf(madeUpThings(2, 2, 3, 1, {4, 0.3, 0.5}), 3);
  training.prior = {0.2F, 0.5F, 0.3F};
  training.shape = {700, true, 9, 0};
  training.targets.classes[1].labels = {"coffee mug", "cup"};
  return training;
}

TEST(ObjectModelFile, IsLoadedExactly) {
  const test::ScratchFolder scratch;
  const ObjectTraining training = small();
  for (const auto& [type, explanation] : classifierTypes()) {
    const ObjectModel model = learned(training, type);
    writeObjectModel(model, scratch / "objects");
    const ObjectModel back = readObjectModel(scratch / "objects");
    EXPECT_EQ(back.predict(training.shapes).values(), model.predict(training.shapes).values());
    EXPECT_EQ(back.targets().names(), model.targets().names());
    EXPECT_EQ(back.targets().classes[1].labels, training.targets.classes[1].labels);
    EXPECT_EQ(back.shape().samples, 700);
    EXPECT_TRUE(back.shape().size);
    EXPECT_EQ(back.shape().seed, 9U);
    EXPECT_EQ(back.labeler(), "a labeler");
    EXPECT_EQ(back.prior(), training.prior);
    EXPECT_EQ(back.heldOutAccuracy(), model.heldOutAccuracy());
    EXPECT_EQ(back.choice(), model.choice());
    writeObjectModel(back, scratch / "again");
    EXPECT_EQ(test::readFile(scratch / "again"), test::readFile(scratch / "objects"));
  }
  EXPECT_TRUE(isObjectModel(scratch / "objects"));
}

TEST(ObjectModelFile, DamagedOnesAreRefused) {
  const test::ScratchFolder scratch;
  writeObjectModel(learned(small()), scratch / "objects");
  const std::string bytes = test::readFile(scratch / "objects");
  const auto load = [&](const std::string& changed) {
    test::writeFile(scratch / "changed", changed);
    return test::caught([&] { readObjectModel(scratch / "changed"); });
  };
  for (std::size_t length = 0; length < bytes.size(); length += 97)
    EXPECT_TRUE(load(bytes.substr(0, length)).code) << length << " of " << bytes.size() << " bytes";
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) {
    std::string mutant = bytes;
    const std::size_t at = random() % bytes.size();
    mutant[at] = static_cast<char>(mutant[at] ^ static_cast<char>(1 + random() % 255));
    EXPECT_TRUE(load(mutant).code.has_value()) << "byte " << at;
  }
  EXPECT_THAT(load(bytes + "x"), FailsWith(ErrorCode::corruptFile));
  EXPECT_THAT(load("hello"), FailsWith(ErrorCode::unsupportedFile));
  std::string newer = bytes;
  newer[8] = 9;
  EXPECT_THAT(load(newer), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { readObjectModel(scratch / "none"); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_FALSE(isObjectModel(scratch / "none"));
  EXPECT_FALSE(isObjectModel(scratch.path()));
}

/// The surface of an ellipsoid with these half axes [m].
PointCloud ellipsoid(const std::array<float, 3>& axes, const cv::Point3f& center = {}, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < 2000; ++i) {
    const cv::Point3f p(normal(random), normal(random), normal(random));
    const float length = std::sqrt(p.dot(p));
    cloud.points.emplace_back(axes[0] * p.x / length + center.x, axes[1] * p.y / length + center.y,
                              axes[2] * p.z / length + center.z);
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// Some views can be described, others are holes, lines, or unreadable.
class Views final : public ObjectViews {
 public:
  explicit Views(std::vector<PointCloud> clouds) : clouds_(std::move(clouds)) {
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      ObjectView& view = views_.emplace_back();
      view.name = "view " + std::to_string(i);
      view.category = i % 2 == 0 ? "even" : "odd";
    }
  }
  std::string name() const override { return "made up"; }
  std::size_t size() const override { return clouds_.size(); }
  const ObjectView& view(std::size_t i) const override { return views_[i]; }
  PointCloud cloud(std::size_t i) const override {
    if (clouds_[i].points.empty()) throw Error(ErrorCode::fileUnreadable, "its file is damaged");
    return clouds_[i];
  }
  ObjectImage image(std::size_t) const override { return {}; }

 private:
  std::vector<PointCloud> clouds_;
  std::vector<ObjectView> views_;
};

ShapeOptions quickShape(bool size = false, int threads = 0) {
  return {300, size, 1, threads};
}

TEST(Shape, PartsAreWhatIsDescribed) {
  const PointCloud ball = ellipsoid({0.1F, 0.1F, 0.1F});
  for (const bool size : {false, true}) {
    const std::vector<DescriptorPart> parts = noShapes(quickShape(size)).parts;
    std::size_t columns = 0;
    for (const DescriptorPart& part : parts) columns += part.size();
    EXPECT_EQ(describeShape(ball, quickShape(size)).size(), columns);
    EXPECT_EQ(parts.size(), size ? 2U : 1U);
  }
  ShapeOptions other = quickShape();
  other.samples = 301;
  EXPECT_NE(noShapes(other).parts[0].identity, noShapes(quickShape()).parts[0].identity);
}

TEST(Shape, SizeIsInMetersWhereverTheThingLies) {
  std::vector<float> numbers = describeShape(ellipsoid({0.1F, 0.4F, 0.2F}, {1, 2, 3}), quickShape(true));
  numbers.erase(numbers.begin(), numbers.end() - 4);
  const float root3 = std::sqrt(3.0F);  // an even sphere spreads by its radius / √3
  EXPECT_NEAR(numbers[0], 0.4F / root3, 0.01);
  EXPECT_NEAR(numbers[1], 0.2F / root3, 0.01);
  EXPECT_NEAR(numbers[2], 0.1F / root3, 0.01);
  EXPECT_NEAR(numbers[3], 0.4F, 0.01);
  PointCloud ball = ellipsoid({0.1F, 0.2F, 0.3F});
  const std::vector<float> whole = describeShape(ball, quickShape(true));
  ball.points.insert(ball.points.begin() + 7, cv::Point3f(NAN, 0, 0));
  ball.width = ball.points.size();
  EXPECT_EQ(describeShape(ball, quickShape(true)), whole) << "holes do not count";
}

TEST(Shape, WhatIsNoShapeIsRefused) {
  PointCloud line;
  for (int i = 0; i < 50; ++i) line.points.emplace_back(0.01F * static_cast<float>(i), 0, 0);
  line.width = 50;
  line.height = 1;
  PointCloud nothing;
  nothing.points.assign(60, {NAN, NAN, NAN});
  for (const bool size : {false, true}) {
    EXPECT_THAT([&] { describeShape(line, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
    EXPECT_THAT([&] { describeShape(nothing, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
    EXPECT_THAT([&] { describeShape({}, quickShape(size)); }, FailsWith(ErrorCode::insufficientData));
  }
  EXPECT_THAT([] { noShapes({.samples = 0}); }, FailsWith(ErrorCode::invalidOption));
  const Views unreadable({{}, {}});
  EXPECT_THAT([&] { describeShapes(unreadable, quickShape()); }, FailsWith(ErrorCode::insufficientData));
}

TEST(Shapes, OfAllViewsWhateverTheThreads) {
  PointCloud holes;
  holes.points.assign(100, {NAN, NAN, NAN});
  const Views views({ellipsoid({1, 1, 1}), holes, ellipsoid({1, 2, 1}), {}, ellipsoid({3, 1, 1})});
  std::vector<std::string> problems, again;
  const Features one = describeShapes(views, quickShape(true, 1), Progress::none(), &problems),
                 four = describeShapes(views, quickShape(true, 4), Progress::none(), &again);
  EXPECT_EQ(one.values.values(), four.values.values());
  EXPECT_EQ(problems, again);
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_EQ(problems[0].substr(0, 6), "view 1");
  EXPECT_EQ(problems[1].substr(0, 6), "view 3");
  ASSERT_EQ(one.frames.size(), 3U);
  EXPECT_EQ(one.frames[1].name, "view 2");
  EXPECT_EQ(one.frames[1].room, "even");
  const std::vector<float> second(one.values.row(1).begin(), one.values.row(1).end());
  EXPECT_EQ(second, describeShape(ellipsoid({1, 2, 1}), quickShape(true)));
  EXPECT_EQ(one.parts, noShapes(quickShape(true)).parts);
}

}  // namespace
}  // namespace estancia
