// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/training.hpp"
#include "made_up.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::MadeUpThings;
using test::madeUpThings;
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
         for (std::size_t i = 0; i < t.shapes.values.size(); ++i) values.append(std::vector<float>(24, NAN));
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

TEST(ObjectModel, BadTrainingDataIsRefused) {
  const auto refusal = [](const ObjectTraining& training) {
    return test::caught([&] { learned(training); });
  };
  const ObjectTraining sound = trainingOf(madeUpThings(3, 2, 5, 1), 3);
  ObjectTraining one = sound;
  std::ranges::fill(one.classes, 2);
  EXPECT_THAT(refusal(one), FailsWith(ErrorCode::insufficientData));
  ObjectTraining none = sound;
  std::ranges::fill(none.classes, -1);
  EXPECT_THAT(refusal(none), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(refusal({sound.targets, {}, {sound.shapes.parts, {}, DescriptorMatrix(24)}, {}, {}, "", {}}),
              FailsWith(ErrorCode::insufficientData));
  ObjectTraining fewer = sound;
  fewer.instances.pop_back();
  EXPECT_THAT(refusal(fewer), FailsWith(ErrorCode::mismatch));
  ObjectTraining unknown = sound;
  unknown.classes[4] = 3;
  EXPECT_THAT(refusal(unknown), FailsWith(ErrorCode::invalidInput));
  ObjectTraining prior = sound;
  prior.prior = {0.5F, 0.5F};
  EXPECT_THAT(refusal(prior), FailsWith(ErrorCode::invalidInput));
  prior.prior = {0.5F, NAN, 0.5F};
  EXPECT_THAT(refusal(prior), FailsWith(ErrorCode::invalidInput));
  ObjectTraining nan = sound;
  DescriptorMatrix values(24);
  for (std::size_t i = 0; i < nan.shapes.values.size(); ++i) {
    std::vector<float> row(nan.shapes.values.row(i).begin(), nan.shapes.values.row(i).end());
    if (i == 7) row[5] = NAN;
    values.append(row);
  }
  nan.shapes.values = values;
  EXPECT_THAT(refusal(nan), FailsWith(ErrorCode::invalidInput));
  ObjectTraining wordless = sound;
  wordless.targets = {};
  EXPECT_THAT(refusal(wordless), FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
