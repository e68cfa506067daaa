// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/core/digest.hpp"
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

/// One thing a word: its views are held out in parts.
TEST(ObjectModel, SingleInstancesAreValidatedInParts) {
  const MadeUpThings things = madeUpThings(3, 1, 10, 1);
  const ObjectModel model = learned(trainingOf(things, 3));
  EXPECT_THAT(model.heldOutAccuracy(), Each(Ge(0.8F)));
  EXPECT_GT(
      test::shareRight(model.predict(madeUpThings(3, 1, 20, 2).shapes), madeUpThings(3, 1, 20, 2).classes),
      0.9);
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

/// Too few views to part: nothing is known of how well the shapes do, and that is said.
TEST(ObjectModel, WhatCannotBeHeldOutIsUnknown) {
  const MadeUpThings things = madeUpThings(3, 1, 2, 1);
  EXPECT_THAT(learned(trainingOf(things, 3)).heldOutAccuracy(), Each(-1));
}

TEST(ObjectModel, DoesNotDependOnThreads) {
  const ObjectTraining training = trainingOf(madeUpThings(3, 3, 6, 1), 3);
  const MadeUpThings asked = madeUpThings(3, 3, 6, 2);
  const ObjectModel one = learned(training, "svm-rbf", 1), three = learned(training, "svm-rbf", 3);
  EXPECT_EQ(one.predict(asked.shapes, 1).values(), three.predict(asked.shapes, 3).values());
  EXPECT_EQ(one.heldOutAccuracy(), three.heldOutAccuracy());
}

TEST(ObjectModel, BadTrainingDataIsRefused) {
  const auto refusal = [](const ObjectTraining& training) {
    return test::caught([&] { learned(training); });
  };
  const ObjectTraining sound = trainingOf(madeUpThings(3, 2, 5, 1), 3);
  ObjectTraining one = sound;
  std::ranges::fill(one.classes, 2);
  EXPECT_THAT(refusal(one), FailsWith(ErrorCode::insufficientData, "\"word 2\""));
  ObjectTraining none = sound;
  std::ranges::fill(none.classes, -1);
  EXPECT_THAT(refusal(none), FailsWith(ErrorCode::insufficientData, "30"));
  EXPECT_THAT(refusal({sound.targets, {}, {sound.shapes.parts, {}, DescriptorMatrix(24)}, {}, {}, "", {}}),
              FailsWith(ErrorCode::insufficientData, "0"));
  ObjectTraining fewer = sound;
  fewer.instances.pop_back();
  EXPECT_THAT(refusal(fewer), FailsWith(ErrorCode::mismatch, "30", "29"));
  ObjectTraining unknown = sound;
  unknown.classes[4] = 3;
  EXPECT_THAT(refusal(unknown), FailsWith(ErrorCode::invalidInput, "4", "3"));
  ObjectTraining prior = sound;
  prior.prior = {0.5F, 0.5F};
  EXPECT_THAT(refusal(prior), FailsWith(ErrorCode::invalidInput, "prior"));
  prior.prior = {0.5F, NAN, 0.5F};
  EXPECT_THAT(refusal(prior), FailsWith(ErrorCode::invalidInput, "prior"));
  ObjectTraining nan = sound;
  DescriptorMatrix values(24);
  for (std::size_t i = 0; i < nan.shapes.values.size(); ++i) {
    std::vector<float> row(nan.shapes.values.row(i).begin(), nan.shapes.values.row(i).end());
    if (i == 7) row[5] = NAN;
    values.append(row);
  }
  nan.shapes.values = values;
  EXPECT_THAT(refusal(nan), FailsWith(ErrorCode::invalidInput, nan.shapes.frames[7].name, "bin 5"));
  ObjectTraining wordless = sound;
  wordless.targets = {};
  EXPECT_THAT(refusal(wordless), FailsWith(ErrorCode::invalidInput));
}

TEST(ObjectModel, OtherShapesAreRefused) {
  const MadeUpThings things = madeUpThings(3, 2, 5, 1);
  const ObjectModel model = learned(trainingOf(things, 3));
  Features other = things.shapes;
  other.parts[0].identity = "esf of another number of samples";
  EXPECT_THAT([&] { model.predict(other); }, FailsWith(ErrorCode::mismatch, "esf 1", "another number"));
  other = things.shapes;
  other.parts[0].name = "gist";
  EXPECT_THAT([&] { model.predict(other); }, FailsWith(ErrorCode::mismatch, "esf", "gist"));
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
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_TRUE(load(bytes.substr(0, length)).code) << length << " of " << bytes.size() << " bytes";
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    std::string mutant = bytes;
    const std::size_t at = random() % bytes.size();
    mutant[at] = static_cast<char>(mutant[at] ^ static_cast<char>(1 + random() % 255));
    EXPECT_TRUE(load(mutant).code.has_value()) << "byte " << at;
  }
  EXPECT_THAT(load(bytes + "x"), FailsWith(ErrorCode::corruptFile, "changed"));
  EXPECT_THAT(load("hello"), FailsWith(ErrorCode::unsupportedFile, "changed"));
  std::string newer = bytes;
  newer[8] = 9;
  EXPECT_THAT(load(newer), FailsWith(ErrorCode::unsupportedFile, "9", "1"));
  EXPECT_THAT([&] { readObjectModel(scratch / "none"); }, FailsWith(ErrorCode::fileNotFound, "none"));
  EXPECT_FALSE(isObjectModel(scratch / "none"));
  EXPECT_FALSE(isObjectModel(scratch.path()));
}

/// A forger can sign what he likes: what stands behind the digest is checked as well.
TEST(ObjectModelFile, ForgedOnesAreRefusedOrHarmless) {
  const test::ScratchFolder scratch;
  const ObjectTraining training = small();
  writeObjectModel(learned(training), scratch / "objects");
  const std::string bytes = test::readFile(scratch / "objects");
  constexpr std::size_t head = 8 + 4 + 64;
  const std::string content = bytes.substr(head);
  int refused = 0;
  const auto load = [&](const std::string& forged) {
    test::writeFile(scratch / "forged", bytes.substr(0, 12) + sha256(forged) + forged);
    try {
      readObjectModel(scratch / "forged").predict(training.shapes, 1);
      return true;
    } catch (const Error&) {
      ++refused;
      return false;
    }
  };
  EXPECT_TRUE(load(content));
  for (std::size_t length = 0; length < content.size(); ++length)
    EXPECT_FALSE(load(content.substr(0, length))) << length << " bytes";
  EXPECT_FALSE(load(content + "x"));
  std::mt19937 random(2);
  for (int i = 0; i < 1500; ++i) {
    std::string forged = content;
    for (int blows = 0; blows < 1 + i % 3; ++blows)
      forged[random() % forged.size()] = static_cast<char>(random());
    load(forged);
  }
  EXPECT_GT(refused, static_cast<int>(content.size()) + 400);
}

}  // namespace
}  // namespace estancia
