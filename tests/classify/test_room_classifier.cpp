// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "estancia/classify/embedding.hpp"
#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "samples.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::madeUpRooms;

RoomClassifier learned(const Features& features, const std::string& type = "svm-linear") {
  ClassifierOptions options = test::typed(type);
  options.c = 1;
  return trainRoomClassifier(features, options);
}

/// Frames with columns in another order; −1 is a new one, of 0.1.
Features reordered(const Features& features, const std::vector<std::vector<int>>& columns) {
  Features result{features.parts, features.frames, DescriptorMatrix(0)};
  std::size_t width = 0;
  for (std::size_t p = 0; p < columns.size(); ++p) {
    result.parts[p].columns.clear();
    for (const int c : columns[p])
      result.parts[p].columns.push_back(c < 0 ? "new"
                                              : features.parts[p].columns[static_cast<std::size_t>(c)]);
    width += columns[p].size();
  }
  result.values = DescriptorMatrix(width);
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::vector<float> row;
    std::size_t first = 0;
    for (std::size_t p = 0; p < columns.size(); ++p) {
      for (const int c : columns[p])
        row.push_back(c < 0 ? 0.1F : features.values.row(i)[first + static_cast<std::size_t>(c)]);
      first += features.parts[p].size();
    }
    result.values.append(row);
  }
  return result;
}

std::vector<int> firstOnes(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(RoomClassifier, NamesRoomsOfNewImages) {
  const RoomClassifier classifier = learned(madeUpRooms(4, 25, 1));
  EXPECT_EQ(classifier.rooms(), (std::vector<std::string>{"room 0", "room 1", "room 2", "room 3"}));
  const Confusion confusion = testRooms(classifier, madeUpRooms(4, 25, 2));
  EXPECT_GT(confusion.accuracy(), 0.9);
  EXPECT_EQ(confusion.total(), 100U);
  EXPECT_EQ(classifier.choice().substr(0, 5), "C 1: ");
}

TEST(RoomClassifier, IsLoadedExactly) {
  const test::ScratchFolder scratch;
  const Features features = madeUpRooms(3, 12, 1), queries = madeUpRooms(3, 12, 2);
  for (const auto& [type, explanation] : classifierTypes()) {
    const RoomClassifier classifier = learned(features, type);
    writeRoomClassifier(classifier, scratch / "rooms");
    const RoomClassifier back = readRoomClassifier(scratch / "rooms");
    EXPECT_EQ(back.rooms(), classifier.rooms());
    EXPECT_EQ(back.choice(), classifier.choice());
    EXPECT_EQ(back.classifier().type(), type);
    EXPECT_EQ(back.trainingImages(), 36U);
    EXPECT_EQ(back.predict(queries).values(), classifier.predict(queries).values());
    writeRoomClassifier(back, scratch / "again");
    EXPECT_EQ(test::readFile(scratch / "again"), test::readFile(scratch / "rooms"));
  }
}

TEST(RoomClassifier, DamagedFilesAreRefused) {
  const test::ScratchFolder scratch;
  writeRoomClassifier(learned(madeUpRooms(3, 8, 1)), scratch / "rooms");
  const std::string bytes = test::readFile(scratch / "rooms");
  const auto load = [&](const std::string& changed) {
    test::writeFile(scratch / "changed", changed);
    return test::caught([&] { readRoomClassifier(scratch / "changed"); });
  };
  std::string flipped = bytes;
  flipped[bytes.size() / 2] ^= 1;
  EXPECT_THAT(load(flipped), FailsWith(ErrorCode::corruptFile));
  EXPECT_TRUE(load(bytes.substr(0, bytes.size() / 2)).code);
  EXPECT_THAT(load(bytes + "x"), FailsWith(ErrorCode::corruptFile));
  EXPECT_THAT(load("hello"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(load(""), FailsWith(ErrorCode::unsupportedFile));
  std::string newer = bytes;
  newer[8] = 9;
  EXPECT_THAT(load(newer), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { readRoomClassifier(scratch / "none"); }, FailsWith(ErrorCode::fileNotFound));
}

/// Stripes, upright or lying.
cv::Mat stripes(bool upright, int width) {
  cv::Mat image(64, 64, CV_8UC3);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<cv::Vec3b>(y, x) = cv::Vec3b::all((upright ? x : y) / width % 2 == 0 ? 40 : 200);
  return image;
}

TEST(RoomClassifier, NamesTheRoomOfAnImage) {
  const auto descriptor = loadDescriptor("phog");
  Features features{descriptor->parts(), {}, DescriptorMatrix(630)};
  for (int i = 0; i < 12; ++i) {
    const Features one = featuresOf(*descriptor, {.image = stripes(i % 2 == 0, 3 + i)});
    features.values.append(one.values.row(0));
    Frame& frame = features.frames.emplace_back();
    frame.name = std::to_string(100 * i) + ".png";
    frame.room = i % 2 == 0 ? "upright" : "lying";
  }
  const RoomClassifier classifier = learned(features, "knn");
  const cv::Mat image = stripes(true, 5);
  const std::vector<RoomProbability> rooms = classifier.predict(image);
  const DescriptorMatrix expected = classifier.predict(featuresOf(*descriptor, {.image = image}));
  ASSERT_EQ(rooms.size(), 2U);
  EXPECT_EQ(rooms[0].room, "upright");
  EXPECT_NEAR(rooms[0].probability, expected.row(0)[1], 1e-6);
  EXPECT_NEAR(rooms[0].probability + rooms[1].probability, 1, 1e-9);
  EXPECT_EQ(classifier.predict(image), rooms) << "the descriptor is loaded once";
  EXPECT_THAT([&] { classifier.predict(cv::Mat()); }, FailsWith(ErrorCode::invalidInput));
}

TEST(RoomClassifier, PartsMayStandInAnyOrderAmongOthers) {
  const Features features = madeUpRooms(3, 10, 1);
  const RoomClassifier classifier = learned(features);
  Features other{{features.parts[1], {"gist", PartKind::energies, {"g"}, "gist 1"}, features.parts[0]},
                 features.frames,
                 DescriptorMatrix(19)};
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    const DescriptorView whole = features.values.row(i);
    std::vector<float> row(whole.begin() + 12, whole.end());
    row.push_back(3);
    row.insert(row.end(), whole.begin(), whole.begin() + 12);
    other.values.append(row);
  }
  EXPECT_EQ(classifier.predict(other).values(), classifier.predict(features).values());
}

TEST(RoomClassifier, WordsFoundSinceAreIgnoredAndThoseNotYetFoundAreZero) {
  const Features features = madeUpRooms(3, 10, 1);
  const RoomClassifier classifier = learned(features);
  const Features grown = reordered(features, {{3, -1, 0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11}, firstOnes(6)});
  EXPECT_EQ(classifier.predict(grown).values(), classifier.predict(features).values());
  Features zero = features;
  zero.values = DescriptorMatrix(18);
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::vector<float> row(features.values.row(i).begin(), features.values.row(i).end());
    row[11] = 0;
    zero.values.append(row);
  }
  EXPECT_EQ(classifier.predict(reordered(features, {firstOnes(11), firstOnes(6)})).values(),
            classifier.predict(zero).values());
}

TEST(RoomClassifier, OtherDescriptorsAreRefused) {
  const Features features = madeUpRooms(3, 10, 1);
  const RoomClassifier classifier = learned(features);
  const auto refusal = [&](const Features& other) {
    return test::caught([&] { classifier.predict(other); });
  };
  Features missing = features;
  missing.parts[0].name = "places";
  EXPECT_THAT(refusal(missing), FailsWith(ErrorCode::mismatch));
  Features model = features;
  model.parts[0].identity = "words 2";
  EXPECT_THAT(refusal(model), FailsWith(ErrorCode::mismatch));
  Features vocabulary = features;
  for (std::string& word : vocabulary.parts[0].columns) word = "Wort " + word;
  EXPECT_THAT(refusal(vocabulary), FailsWith(ErrorCode::mismatch));
  Features parameters = reordered(features, {firstOnes(12), firstOnes(5)});
  EXPECT_THAT(refusal(parameters), FailsWith(ErrorCode::mismatch));
}

TEST(RoomClassifier, NamesTheColumnsOfATableThatDiffer) {
  Features table = madeUpRooms(3, 10, 1);
  for (DescriptorPart& part : table.parts) part.identity = "table " + part.name;
  const RoomClassifier classifier = learned(table);
  EXPECT_THAT([&] { requireDescribable(classifier); }, FailsWith(ErrorCode::mismatch));
  EXPECT_EQ(classifier.predict(table).size(), table.values.size());
  for (const int lost : {1, 4, 0}) {
    std::vector<int> kept = firstOnes(12);
    kept.erase(kept.begin(), kept.begin() + lost);
    if (lost == 0) kept.push_back(-1);
    const auto refused = test::caught([&] { classifier.predict(reordered(table, {kept, firstOnes(6)})); });
    EXPECT_THAT(refused, FailsWith(ErrorCode::mismatch, lost == 0 ? "new: new" : "new: none")) << lost;
    EXPECT_EQ(refused.message.find("word 0") != std::string::npos, lost > 0) << refused;
    EXPECT_EQ(refused.message.find(" …") != std::string::npos, lost > 3) << "three of four are named";
  }
}

TEST(RoomClassifier, BadTrainingDataIsRefused) {
  const auto refusal = [](const Features& features) { return test::caught([&] { learned(features); }); };
  Features nan = madeUpRooms(3, 6, 1);
  std::vector<float> row(nan.values.row(4).begin(), nan.values.row(4).end());
  row[13] = std::nanf("");
  nan.frames.push_back(nan.frames[4]);
  nan.values.append(row);
  EXPECT_THAT(refusal(nan), FailsWith(ErrorCode::invalidInput));
  Features single = madeUpRooms(3, 6, 1);
  single.frames[0].room = "cellar";
  EXPECT_THAT(refusal(single), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(refusal(madeUpRooms(1, 6, 1)), FailsWith(ErrorCode::insufficientData));
  Features none = madeUpRooms(2, 6, 1);
  for (Frame& frame : none.frames) frame.room.clear();
  EXPECT_THAT(refusal(none), FailsWith(ErrorCode::insufficientData, "--rooms"));
  EXPECT_TRUE(refusal({{}, {}, DescriptorMatrix(0)}).code);
  EXPECT_THAT(
      [] {
        FeatureEmbedding::learn({{}, {}, DescriptorMatrix(0)});
      },
      FailsWith(ErrorCode::insufficientData));
  Features empty = madeUpRooms(2, 6, 1);
  empty.parts.push_back({"nothing", PartKind::energies, {}, "nothing 1"});
  EXPECT_THAT([&] { FeatureEmbedding::learn(empty); }, FailsWith(ErrorCode::invalidInput));
}

TEST(FeatureEmbedding, BalancesPartsWhateverTheirNumberOfColumns) {
  const Features features = madeUpRooms(3, 20, 1, 40, 3);
  const DescriptorMatrix x = FeatureEmbedding::learn(features).apply(features);
  double words = 0, bins = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t c = 0; c < x.labels(); ++c)
      (c < 40 ? words : bins) +=
          static_cast<double>(x.row(i)[c]) * x.row(i)[c] / static_cast<double>(x.size());
  EXPECT_NEAR(words, 1 / 1.2, 1e-4);
  EXPECT_NEAR(bins, 0.2 / 1.2, 1e-4);
}

/// Two images with these probabilities, embedded.
DescriptorMatrix embeddedPair(const std::vector<float>& a, const std::vector<float>& b) {
  Features features{{{"model", PartKind::probabilities, {"bed", "lamp", "sofa"}, "model 1"}},
                    std::vector<Frame>(2),
                    DescriptorMatrix(3)};
  features.values.append(a);
  features.values.append(b);
  return FeatureEmbedding::learn(features).apply(features);
}

/// The centered coordinates of two images are ± half the difference, scaled alike.
void expectDirection(const DescriptorMatrix& x, const std::vector<double>& expected) {
  double norm = 0;
  for (const double v : expected) norm += v * v;
  for (std::size_t c = 0; c < expected.size(); ++c)
    EXPECT_NEAR(x.row(0)[c], expected[c] / std::sqrt(norm), 1e-3) << "column " << c;
}

TEST(FeatureEmbedding, SharesOfAWholeAreComparedByLogRatiosIndependentOnesByLogOdds) {
  const double a = std::log(0.2 / 0.5), b = std::log(0.3 / 0.4), c = std::log(0.5 / 0.1),
               mean = (a + b + c) / 3;
  expectDirection(embeddedPair({0.2F, 0.3F, 0.5F}, {0.5F, 0.4F, 0.1F}), {a - mean, b - mean, c - mean});
  const auto odds = [](double p) { return std::log(p / (1 - p)); };
  expectDirection(embeddedPair({0.9F, 0.3F, 0.5F}, {0.5F, 0.4F, 0.8F}),
                  {odds(0.9) - odds(0.5), odds(0.3) - odds(0.4), odds(0.5) - odds(0.8)});
  const DescriptorMatrix extremes = embeddedPair({1, 0, 1}, {1, 1, 0});
  for (const float v : extremes.values()) EXPECT_TRUE(std::isfinite(v));
}

TEST(FeatureEmbedding, AWordAboveOneIsRefused) {
  Features features = madeUpRooms(3, 6, 1);
  const RoomClassifier classifier = learned(features);
  std::vector<float> row(features.values.row(0).begin(), features.values.row(0).end());
  row[3] = 50;
  features.values.append(row);
  features.frames.push_back(features.frames[0]);
  features.frames.back().name = "loud";
  const auto refused = FailsWith(ErrorCode::invalidInput);
  EXPECT_THAT([&] { learned(features); }, refused);
  EXPECT_THAT([&] { classifier.predict(features); }, refused);
}

TEST(Embedding, RowsOfBestLabelsAreWholeDistributions) {
  Features features = madeUpRooms(2, 20, 1);
  Features best = features;
  best.values = DescriptorMatrix(features.values.labels());
  const std::size_t labels = features.parts.front().size();
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    const DescriptorView row = features.values.row(i);
    std::vector<float> kept(row.begin(), row.end());
    const float most = *std::max_element(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(labels));
    for (std::size_t c = 0; c < labels; ++c)
      if (kept[c] < most) kept[c] = 0;
    best.values.append(kept);
  }
  EXPECT_EQ(FeatureEmbedding::learn(best).parts().front().sums, LabelSums::whole);
}

// ---- selection

TEST(Selection, FindsTheColumnsThatTell) {
  const Features features = madeUpRooms(3, 40, 1, 12, 6);  // bins 0 … 2 depend on the rooms, 3 … 5 do not
  for (const char* criterion : {"mutual-information", "chi2"}) {
    const std::vector<double> scores = columnScores(features, criterion);
    for (const std::size_t telling : {12U, 13U, 14U})
      for (const std::size_t silent : {15U, 16U, 17U})
        EXPECT_GT(scores[telling], scores[silent]) << criterion;
  }
  const std::vector<std::size_t> best = selectColumns(features, "mean", 3);
  const std::vector<double> means = columnScores(features, "mean");
  EXPECT_EQ(best.size(), 3U);
  EXPECT_EQ(means[best[0]], *std::max_element(means.begin(), means.end()));
  EXPECT_GE(means[best[1]], means[best[2]]);
}

TEST(Selection, AClassifierOfFewWordsReadsWholeDescriptors) {
  const Features features = madeUpRooms(3, 15, 1), queries = madeUpRooms(3, 15, 2);
  const std::vector<std::size_t> columns{0, 3, 5, 7};
  const RoomClassifier classifier = learned(withColumns(features, columns));
  EXPECT_EQ(classifier.embedding().columns(), 4U);
  EXPECT_EQ(classifier.predict(queries).values(), classifier.predict(withColumns(queries, columns)).values());
}

TEST(Selection, BadRequestsAreRefused) {
  const Features features = madeUpRooms(2, 5, 1);
  EXPECT_THAT([&] { selectColumns(features, "mean", 19); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { selectColumns(features, "mean", 0); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { selectColumns(features, "size", 2); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { withColumns(features, {18}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { withColumns(features, {}); }, FailsWith(ErrorCode::invalidInput));
  Features unknown = features, nan = features;
  for (Frame& frame : unknown.frames) frame.room.clear();
  EXPECT_THAT([&] { columnScores(unknown, "chi2"); }, FailsWith(ErrorCode::insufficientData));
  nan.frames.push_back(nan.frames[0]);
  nan.values.append(std::vector<float>(18, std::nanf("")));
  EXPECT_THAT([&] { columnScores(nan, "mean"); }, FailsWith(ErrorCode::invalidInput));
  nan.values = DescriptorMatrix(18);
  EXPECT_THAT([&] { columnScores(nan, "mean"); }, FailsWith(ErrorCode::insufficientData));
}

// ---- scores

TEST(Scores, ConfusionCountsWhatWasTakenForWhat) {
  const Confusion confusion = confusionOf({"a", "a", "a", "b", "c"}, {"a", "b", "a", "b", "d"});
  EXPECT_EQ(confusion.rooms, (std::vector<std::string>{"a", "b", "c", "d"}));
  EXPECT_EQ(confusion.counts[0], (std::vector<std::size_t>{2, 1, 0, 0}));
  EXPECT_DOUBLE_EQ(confusion.accuracy(), 0.6);
  EXPECT_DOUBLE_EQ(confusion.balancedAccuracy(), (2.0 / 3 + 1 + 0) / 3);
  EXPECT_THAT([] { confusionOf({}, {}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([] { confusionOf({"a"}, {}); }, FailsWith(ErrorCode::mismatch));
}

/// Six gray images: stripes across, and down.
class Stripes : public Sequence {
 public:
  explicit Stripes(const std::vector<std::string>& names) {
    for (const auto& name : names)
      frames_.push_back({name, {}, {}, name.starts_with("a") ? "across" : "down"});
  }
  std::string name() const override { return "stripes"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override {
    cv::Mat image(64, 64, CV_8UC3, cv::Scalar::all(40));
    for (int at = 4 + static_cast<int>(i); at < 60; at += 12)
      (frames_[i].room == "across" ? image.rowRange(at, at + 4) : image.colRange(at, at + 4)).setTo(200);
    return image;
  }
  bool hasDepth() const override { return depth; }
  bool depth = false;

 private:
  std::vector<Frame> frames_;
};

TEST(RoomPredictions, WhatNeedsDepthIsRefusedWithoutOrWithoutItsCamera) {
  Features shapes = madeUpRooms(3, 10, 1);
  shapes.parts[1].name = "esf";
  shapes = withColumns(shapes, {12, 13, 14, 15, 16, 17});
  Stripes images({"a1", "d1"});
  for (const bool depth : {false, true}) {
    images.depth = depth;
    EXPECT_THAT([&] { requireDescribable(learned(shapes), images); }, FailsWith(ErrorCode::invalidInput));
  }
}

TEST(RoomPredictions, WhatTheLabelsLackIsDescribedFromTheImages) {
  const Stripes images({"a1", "a2", "a3", "d1", "d2", "d3"});
  DescriptorSequence labels{Vocabulary({"desk", "bed"}), "words 1", {}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < images.size(); ++i) {
    labels.frames.push_back(images.frame(i));
    labels.descriptors.append(std::vector<float>{0.5F, 0.5F});  // words alike
  }
  Features both = featuresOf(labels);
  const Features shapes = describeSequence(images, "phog");
  both.parts.push_back(shapes.parts[0]);
  both.values = DescriptorMatrix(2 + shapes.values.labels());
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::vector<float> row{0.5F, 0.5F};
    row.insert(row.end(), shapes.values.row(i).begin(), shapes.values.row(i).end());
    both.values.append(row);
  }
  const RoomClassifier classifier = learned(both);
  const RoomPredictions found =
      predictRooms(classifier, featuresFor(classifier, labels, &images), labels.frames);
  for (std::size_t i = 0; i < images.size(); ++i)
    EXPECT_EQ(rankedRooms(found, i).front().room, images.frame(i).room) << i;
  EXPECT_THAT([&] { featuresFor(classifier, labels); }, FailsWith(ErrorCode::mismatch)) << "no images";
  const Stripes others({"x1", "x2"});
  EXPECT_THAT([&] { featuresFor(classifier, labels, &others); }, FailsWith(ErrorCode::mismatch));
  EXPECT_EQ(featuresFor(learned(shapes), labels, &images).parts[0].name, "phog");
  EXPECT_NO_THROW(requireDescribable(learned(shapes), images));
}

TEST(RoomPredictionFiles, LeaveTheRoomOutBelowTheSmallestProbability) {
  RoomPredictions predictions{"test", {"bath", "hall, long"}, DescriptorMatrix(2)};
  predictions.probabilities.append(std::vector<float>{0.25F, 0.75F});
  predictions.probabilities.append(std::vector<float>{0, 0});
  std::vector<Frame> frames(2);
  frames[0].name = "a.png";
  frames[1].name = "b.png";
  EXPECT_EQ(predictionsCsv(predictions, frames, 0.5), std::string(predictionsCsvHeader) +
                                                          "a.png,\"hall, long\",0.750000,bath,0.250000\n"
                                                          "b.png,,,,\n");
  EXPECT_EQ(predictionsCsv(predictions, frames, 0.8).find("a.png,,0.75"), predictionsCsvHeader.size());
  const auto json = predictionJson(predictions, frames, 0, 0.8);
  EXPECT_EQ(json["room"], nullptr);
  EXPECT_EQ(json["probability"], 0.75);
  EXPECT_EQ(json["rooms"]["bath"], 0.25);
  EXPECT_EQ(predictionJson(predictions, frames, 0)["room"], "hall, long");
  EXPECT_EQ(predictionJson(predictions, frames, 1)["probability"], nullptr);
}

/// A forger can sign what he likes: what stands behind the digest is checked as well.
TEST(RoomClassifier, ForgedFilesAreRefusedOrHarmless) {
  const test::ScratchFolder scratch;
  const Features features = madeUpRooms(3, 8, 1);
  constexpr std::size_t head = 8 + 4 + 64;
  const std::string words[] = {test::bytesOf(0), test::bytesOf(-1), test::bytesOf(1 << 30),
                               test::bytesOf(INFINITY)};
  std::mt19937 random(2);
  for (const auto& [type, explanation] : classifierTypes()) {
    ClassifierOptions options = test::typed(type);
    options.c = 1;
    options.trees = 3;
    writeRoomClassifier(trainRoomClassifier(features, options), scratch / "rooms");
    const std::string bytes = test::readFile(scratch / "rooms");
    int refused = 0;
    for (std::size_t i = 0; i < 400; ++i) {
      std::string content = bytes.substr(head);
      const std::size_t behind = i % 2 == 0 ? 0 : content.size() - std::min<std::size_t>(content.size(), 400);
      const std::size_t at = behind + random() % (content.size() - behind - 4);
      if (i % 4 == 0)
        content.resize(at);
      else if (i % 4 == 1)
        content.replace(at, 4, words[random() % 4]);
      else
        for (std::size_t blows = 0; blows < 1 + i % 3; ++blows)
          content[random() % content.size()] = static_cast<char>(random());
      test::writeFile(scratch / "forged", bytes.substr(0, 12) + sha256(content) + content);
      try {
        readRoomClassifier(scratch / "forged").predict(features, 1);
      } catch (const Error&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, 105) << type;
  }
}

}  // namespace
}  // namespace estancia
