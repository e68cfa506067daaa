// What things are: by image, by shape, and over time.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "estancia/core/take_interrupt.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/predict_sequence.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/readers/object_views.hpp"
#include "support/errors.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Answers "ball" for red images, "box" for blue ones, "nothing" for all others.
class Colors : public Labeler {
 public:
  explicit Colors(std::size_t batch = 3) : batch_(batch) {}
  const Vocabulary& vocabulary() const override { return words_; }
  std::string identity() const override { return "colors"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override {
    if (broken) throw FrameError("the image is broken");
    return {bgr, frame, {}};
  }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const cv::Scalar mean = cv::mean(prepared.input);
    const double difference = mean[2] - mean[0];
    if (std::abs(difference) < 10) return {0, 0, 1};
    const float p = bias;
    return difference > 0 ? LexicalDescriptor{p, 0.9F - p, 0.1F} : LexicalDescriptor{0.9F - p, p, 0.1F};
  }
  std::size_t batchSize() const override { return batch_; }

  bool broken = false;
  float bias = 0.7F;

 private:
  std::size_t batch_;
  Vocabulary words_{{"ball", "box", "nothing"}};
};

TargetClasses ballsAndBoxes() {
  return targetClassesOf({"ball", "box"});
}

/// Three balls and three boxes, no two alike.
std::vector<Solid> things(const cv::Vec3b& ofBalls = red, const cv::Vec3b& ofBoxes = blue) {
  return {ballAt(0.2, 0.2, 0.05, ofBalls),
          ballAt(0.0, 0.2, 0.06, ofBalls),
          ballAt(-0.2, 0.2, 0.07, ofBalls),
          boxAt(0.2, -0.15, {0.05, 0.04, 0.06}, ofBoxes),
          boxAt(0.0, -0.15, {0.04, 0.06, 0.05}, ofBoxes),
          boxAt(-0.2, -0.15, {0.05, 0.05, 0.07}, ofBoxes)};
}

class Predicting : public testing::Test {
 protected:
  /// Collected, labeled by color, and learned.
  static ObjectModel learned(const TrainingOptions& given = {}) {
    const ScratchFolder scratch;
    const auto folder = scratch / "things";
    collectObjects(TableSequence(things(), {0, 15, 30, 45}), folder, {});
    const auto views = openObjectViews(folder);
    Colors labeler;
    const auto patches = cropsOf(*views);
    LabeledViews labeled{views.get(), labelAll(*patches, labeler, "")};
    TrainingOptions options = given;
    options.classifier.type = "svm-linear";
    options.allViews = true;
    const auto gathered = gatherTraining({&labeled, 1}, ballsAndBoxes(), options);
    EXPECT_GE(gathered.samples[0], 10U);
    EXPECT_GE(gathered.samples[1], 10U);
    return trainObjectModel(gathered.training, options.classifier);
  }
  static const ObjectModel& model() {
    static const ObjectModel once = learned();
    return once;
  }
  static std::vector<PredictedObject> predict(ObjectPredictor& predictor, const TableSequence& sequence,
                                              std::size_t frame = 0) {
    return predictor.predict(
        clusteredFrame(sequence.image(frame), sequence.depth(frame), *sequence.intrinsics()),
        sequence.frame(frame).pose);
  }
};

TEST_F(Predicting, ImagesAndShapesAgreeOnWhatIsSeen) {
  Colors labeler;
  ObjectPredictor predictor(model(), &labeler);
  EXPECT_TRUE(predictor.correctsPrior());
  const TableSequence sequence({ballAt(0.1, 0.15, 0.055, red), boxAt(0, -0.1, {0.05, 0.05, 0.06}, blue)},
                               {60});
  const auto objects = predict(predictor, sequence);
  ASSERT_THAT(objects, SizeIs(2));
  for (const PredictedObject& object : objects) {
    EXPECT_EQ(object.problem, "");
    EXPECT_NEAR(object.coverage, 0.9, 1e-6);
    ASSERT_THAT(object.image, SizeIs(2));
    ASSERT_THAT(object.shape, SizeIs(2));
    const bool ball = sequence.image(0).at<cv::Vec3b>(object.box.y + object.box.height / 2,
                                                      object.box.x + object.box.width / 2) == red;
    EXPECT_EQ(object.answer.classIndex, ball ? 0 : 1) << object.answer.why;
    EXPECT_EQ(object.answer.source, FusedAnswer::Source::both) << object.answer.why;
  }
}

TEST_F(Predicting, InTheDarkTheShapeIsBelieved) {
  Colors labeler;
  ObjectPredictor predictor(model(), &labeler);
  TableSequence sequence({ballAt(0, 0, 0.055, red)}, {60});
  sequence.dim(0.02);
  const auto objects = predict(predictor, sequence);
  ASSERT_THAT(objects, SizeIs(1));
  EXPECT_EQ(objects[0].answer.source, FusedAnswer::Source::shape) << objects[0].answer.why;
  EXPECT_EQ(objects[0].answer.classIndex, 0);
}

TEST_F(Predicting, WithoutAnAnswerOfALabelerTheShapeIsBelieved) {
  Colors labeler, broken;
  broken.broken = true;
  const cv::Vec3b gray{200, 200, 200};  // all of the labeler's answer is about other words
  for (Labeler* each :
       {static_cast<Labeler*>(nullptr), static_cast<Labeler*>(&labeler), static_cast<Labeler*>(&broken)}) {
    ObjectPredictor predictor(model(), each);
    const auto objects = predict(predictor, {{ballAt(0, 0, 0.055, gray)}, {60}});
    ASSERT_THAT(objects, SizeIs(1));
    EXPECT_THAT(objects[0].image, IsEmpty());
    EXPECT_EQ(objects[0].problem, each == &broken ? "the image is broken" : "");
    EXPECT_EQ(objects[0].answer.source, FusedAnswer::Source::shape);
    EXPECT_EQ(objects[0].answer.classIndex, 0);
  }
  ObjectPredictor predictor(model(), &labeler);
  EXPECT_THAT(predict(predictor, {std::vector<Solid>{}, {0}}), IsEmpty()) << "nothing is there";
}

TEST_F(Predicting, ViewsOfAThingArePooled) {
  Colors labeler;
  ObjectPredictor predictor(model(), &labeler);
  const TableSequence sequence({ballAt(0, 0, 0.055, red)}, {0, 10, 20});
  for (std::size_t i = 0; i < 3; ++i) {
    labeler.bias = i == 1 ? 0.3F : 0.8F;  // once it is wrong, by little
    const auto objects = predict(predictor, sequence, i);
    ASSERT_THAT(objects, SizeIs(1));
    EXPECT_EQ(objects[0].instance, 0U);
    EXPECT_EQ(objects[0].views, i + 1);
    EXPECT_EQ(objects[0].answer.classIndex, 0) << i;
    if (i == 1) {
      EXPECT_LT(objects[0].image[0], objects[0].image[1]);
    }
  }
}

TEST_F(Predicting, BatchesAndThreadsDoNotMatter) {
  const TableSequence sequence(things(), {60});
  std::vector<PredictedObject> expected;
  for (const auto& [batch, threads] : {std::pair(1, 1), std::pair(4, 3)}) {
    Colors labeler(static_cast<std::size_t>(batch));
    ObjectPredictor predictor(model(), &labeler, {.threads = threads});
    const auto objects = predict(predictor, sequence);
    if (expected.empty()) expected = objects;
    ASSERT_EQ(objects.size(), expected.size());
    EXPECT_GE(objects.size(), 5U);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      EXPECT_EQ(objects[i].image, expected[i].image);
      EXPECT_EQ(objects[i].shape, expected[i].shape);
      EXPECT_EQ(objects[i].answer.why, expected[i].answer.why);
    }
  }
}

TEST_F(Predicting, AnotherLabelerIsNotCorrected) {
  class Other : public Colors {
    std::string identity() const override { return "another"; }
  } other;
  EXPECT_FALSE(ObjectPredictor(model(), &other).correctsPrior());
  EXPECT_FALSE(ObjectPredictor(model(), nullptr).correctsPrior());
  TrainingOptions plain;
  plain.correctPrior = false;
  Colors same;
  EXPECT_FALSE(ObjectPredictor(learned(plain), &same).correctsPrior());
}

TEST_F(Predicting, LabelersWithoutTheWordsAreRefused) {
  class Birds : public Colors {
    const Vocabulary& vocabulary() const override { return words_; }
    Vocabulary words_{{"robin", "wren"}};
  } birds;
  EXPECT_THAT([&] { ObjectPredictor(model(), &birds); }, FailsWith(ErrorCode::unknownName));
  class Discovering : public Colors {
    bool discovers() const override { return true; }
  } discovering;
  EXPECT_THAT([&] { ObjectPredictor(model(), &discovering); }, FailsWith(ErrorCode::invalidInput));
}

TEST_F(Predicting, ASequenceIsSampled) {
  const TableSequence sequence(things(), {0, 15, 30, 45, 60});
  const auto framesOf = [&](const PredictSequenceOptions& options) {
    ObjectPredictor predictor(model(), nullptr);
    std::vector<std::string> names;
    const std::size_t count = predictSequence(sequence, predictor, options, [&](const PredictedFrame& frame) {
      EXPECT_THAT(frame.objects, SizeIs(frame.frame.clusters.clusters.size()));
      EXPECT_GT(frame.clusterSeconds, 0);
      names.push_back(frame.name);
    });
    EXPECT_EQ(count, names.size());
    return names;
  };
  const auto name = [&](std::size_t i) { return sequence.frame(i).name; };
  EXPECT_THAT(framesOf({}), SizeIs(5));
  requestInterrupt();
  EXPECT_THAT(framesOf({}), IsEmpty()) << "it stops when asked";
  Colors labeler;
  ObjectPredictor labeling(model(), &labeler);
  EXPECT_THAT([&] { predict(labeling, sequence); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
  PredictSequenceOptions options;
  options.first = 1;
  options.every = 2;
  EXPECT_EQ(framesOf(options), (std::vector{name(1), name(3)}));
  options.maxFrames = 1;
  EXPECT_EQ(framesOf(options), std::vector{name(1)});
  options.first = 5;
  EXPECT_THAT([&] { framesOf(options); }, FailsWith(ErrorCode::invalidOption));
  options.every = 0;
  EXPECT_THAT([&] { framesOf(options); }, FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia::test
