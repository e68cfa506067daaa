// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estancia/classify/embedding.hpp"
#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/classify/scores.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/describe/load_descriptor.hpp"
#include "samples.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::madeUpRooms;

RoomClassifier learned(const Features& features, const std::string& type = "svm-linear") {
  ClassifierOptions options = test::typed(type);
  options.c = 1;
  return trainRoomClassifier(features, options);
}

/// The same frames with columns in another order; −1 is a new one, of 0.1.
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

TEST(RoomClassifier, FramesWithoutRoomAreLeftOut) {
  Features features = madeUpRooms(3, 10, 1);
  const RoomClassifier all = learned(features);
  Frame stray;
  stray.name = "stray";
  features.frames.push_back(stray);
  features.values.append(std::vector<float>(18, 0.5F));
  EXPECT_EQ(learned(features).predict(features).values(), all.predict(features).values());
  EXPECT_EQ(testRooms(all, features).total(), 30U);
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
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string mutant = bytes;
    const std::size_t at = random() % bytes.size();
    if (i % 3 == 0)
      mutant.resize(at);
    else
      mutant[at] = static_cast<char>(mutant[at] ^ static_cast<char>(1 + random() % 255));
    EXPECT_TRUE(load(mutant).code.has_value()) << "byte " << at;
  }
  EXPECT_THAT(load(bytes + "x"), FailsWith(ErrorCode::corruptFile, "changed"));
  EXPECT_THAT(load("hello"), FailsWith(ErrorCode::unsupportedFile, "changed"));
  EXPECT_THAT(load(""), FailsWith(ErrorCode::unsupportedFile, "changed"));
  std::string newer = bytes;
  newer[8] = 9;
  EXPECT_THAT(load(newer), FailsWith(ErrorCode::unsupportedFile, "9", "2"));
  EXPECT_THAT([&] { readRoomClassifier(scratch / "none"); }, FailsWith(ErrorCode::fileNotFound, "none"));
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
  EXPECT_THAT([&] { classifier.predict(cv::Mat()); }, FailsWith(ErrorCode::invalidInput, "phog"));
}

/// A forger can sign what he likes: what stands behind the digest is checked as well.
TEST(RoomClassifier, ForgedFilesAreRefusedOrHarmless) {
  const test::ScratchFolder scratch;
  const Features features = madeUpRooms(3, 8, 1);
  writeRoomClassifier(learned(features), scratch / "rooms");
  const std::string bytes = test::readFile(scratch / "rooms");
  constexpr std::size_t head = 8 + 4 + 64;
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string content = bytes.substr(head);
    if (i % 4 == 0)
      content.resize(random() % content.size());
    else
      for (int blows = 0; blows < 1 + i % 3; ++blows)
        content[random() % content.size()] = static_cast<char>(random());
    test::writeFile(scratch / "forged", bytes.substr(0, 12) + sha256(content) + content);
    try {
      readRoomClassifier(scratch / "forged").predict(features, 1);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 400);
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
  EXPECT_THAT(refusal(missing), FailsWith(ErrorCode::mismatch, "words", "places, bins"));
  Features model = features;
  model.parts[0].identity = "words 2";
  EXPECT_THAT(refusal(model), FailsWith(ErrorCode::mismatch, "words 1", "words 2"));
  Features vocabulary = features;
  for (std::string& word : vocabulary.parts[0].columns) word = "Wort " + word;
  EXPECT_THAT(refusal(vocabulary), FailsWith(ErrorCode::mismatch, "Wort"));
  Features parameters = reordered(features, {firstOnes(12), firstOnes(5)});
  EXPECT_THAT(refusal(parameters), FailsWith(ErrorCode::mismatch, "6", "bins", "5"));
}

TEST(RoomClassifier, BadTrainingDataIsRefused) {
  const auto refusal = [](const Features& features) { return test::caught([&] { learned(features); }); };
  Features nan = madeUpRooms(3, 6, 1);
  DescriptorMatrix values(18);
  for (std::size_t i = 0; i < nan.values.size(); ++i) {
    std::vector<float> row(nan.values.row(i).begin(), nan.values.row(i).end());
    if (i == 4) row[13] = std::nanf("");
    values.append(row);
  }
  nan.values = values;
  EXPECT_THAT(refusal(nan), FailsWith(ErrorCode::invalidInput, nan.frames[4].name, "bin 1"));
  Features single = madeUpRooms(3, 6, 1);
  single.frames[0].room = "cellar";
  EXPECT_THAT(refusal(single), FailsWith(ErrorCode::insufficientData, "cellar", single.frames[0].name));
  Features one = madeUpRooms(1, 6, 1);
  EXPECT_THAT(refusal(one), FailsWith(ErrorCode::insufficientData, "\"room 0\""));
  Features none = madeUpRooms(2, 6, 1);
  for (Frame& frame : none.frames) frame.room.clear();
  EXPECT_THAT(refusal(none), FailsWith(ErrorCode::insufficientData, "--rooms"));
  EXPECT_TRUE(refusal({{}, {}, DescriptorMatrix(0)}).code);
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

TEST(FeatureEmbedding, ConstantColumnsBecomeZero) {
  Features features = madeUpRooms(2, 10, 1);
  DescriptorMatrix values(18);
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::vector<float> row(features.values.row(i).begin(), features.values.row(i).end());
    row[15] = 0.37F;
    values.append(row);
  }
  features.values = values;
  const DescriptorMatrix x = FeatureEmbedding::learn(features).apply(features);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(x.row(i)[15], 0);
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

/// Of two images the centered coordinates are ± half the difference, scaled alike.
void expectDirection(const DescriptorMatrix& x, const std::vector<double>& expected) {
  double norm = 0;
  for (const double v : expected) norm += v * v;
  for (std::size_t c = 0; c < expected.size(); ++c)
    EXPECT_NEAR(x.row(0)[c], expected[c] / std::sqrt(norm), 1e-3) << "column " << c;
}

TEST(FeatureEmbedding, SharesOfAWholeAreComparedByLogRatios) {
  const double a = std::log(0.2 / 0.5), b = std::log(0.3 / 0.4), c = std::log(0.5 / 0.1),
               mean = (a + b + c) / 3;
  expectDirection(embeddedPair({0.2F, 0.3F, 0.5F}, {0.5F, 0.4F, 0.1F}), {a - mean, b - mean, c - mean});
}

TEST(FeatureEmbedding, IndependentProbabilitiesAreComparedByLogOdds) {
  const auto odds = [](double p) { return std::log(p / (1 - p)); };
  expectDirection(embeddedPair({0.9F, 0.3F, 0.5F}, {0.5F, 0.4F, 0.8F}),
                  {odds(0.9) - odds(0.5), odds(0.3) - odds(0.4), odds(0.5) - odds(0.8)});
  const DescriptorMatrix extremes = embeddedPair({1, 0, 1}, {1, 1, 0});
  for (const float v : extremes.values()) EXPECT_TRUE(std::isfinite(v));
}

/// Images of one word each, at these probabilities, of two rooms by turns.
Features oneWord(const std::vector<float>& probabilities) {
  Features features{{{"model", PartKind::probabilities, {"bed"}, "model 1"}}, {}, DescriptorMatrix(1)};
  for (const float p : probabilities) {
    Frame frame;
    frame.name = "frame " + std::to_string(features.frames.size());
    frame.room = features.frames.size() % 2 == 0 ? "bedroom" : "kitchen";
    features.frames.push_back(frame);
    features.values.append(std::vector<float>{p});
  }
  return features;
}

TEST(FeatureEmbedding, ASelectionOfSharesIsComparedWithTheRest) {
  // The first two of three: what they leave of 1 is the third.
  const double a = std::log(0.2 / 0.5), b = std::log(0.3 / 0.1), rest = std::log(0.5 / 0.4),
               mean = (a + b + rest) / 3;
  Features features{{{"model", PartKind::probabilities, {"bed", "lamp"}, "model 1"}},
                    std::vector<Frame>(2),
                    DescriptorMatrix(2)};
  features.values.append(std::vector<float>{0.2F, 0.3F});
  features.values.append(std::vector<float>{0.5F, 0.1F});
  expectDirection(FeatureEmbedding::learn(features).apply(features), {a - mean, b - mean});
}

TEST(FeatureEmbedding, OneTellingWordIsEnough) {
  std::vector<float> probabilities;
  for (int i = 0; i < 20; ++i) {
    probabilities.push_back(0.6F + 0.01F * static_cast<float>(i));
    probabilities.push_back(0.05F + 0.01F * static_cast<float>(i));
  }
  const Features features = oneWord(probabilities);
  const RoomClassifier classifier = learned(features, "linear");
  EXPECT_EQ(testRooms(classifier, features).accuracy(), 1);
  const test::ScratchFolder scratch;
  writeRoomClassifier(classifier, scratch / "rooms");
  EXPECT_EQ(readRoomClassifier(scratch / "rooms").predict(features).values(),
            classifier.predict(features).values());
}

TEST(FeatureEmbedding, OneSlipDoesNotMakeWordsIndependent) {
  Features features = madeUpRooms(3, 20, 1);
  const auto kept = FeatureEmbedding::learn(features).parts()[0].sums;
  std::vector<float> row(features.values.row(0).begin(), features.values.row(0).end());
  row[0] += 0.0015F;
  Frame frame = features.frames[0];
  frame.name = "slip";
  features.frames.push_back(frame);
  features.values.append(row);
  EXPECT_EQ(kept, LabelSums::whole);
  EXPECT_EQ(FeatureEmbedding::learn(features).parts()[0].sums, LabelSums::whole);
}

TEST(FeatureEmbedding, AWordAboveOneIsRefused) {
  Features features = madeUpRooms(3, 6, 1);
  const RoomClassifier classifier = learned(features);
  std::vector<float> row(features.values.row(0).begin(), features.values.row(0).end());
  row[3] = 50;
  features.values.append(row);
  features.frames.push_back(features.frames[0]);
  features.frames.back().name = "loud";
  const auto refused = FailsWith(ErrorCode::invalidInput, "loud", "word 3", "50", "softmax");
  EXPECT_THAT([&] { learned(features); }, refused);
  EXPECT_THAT([&] { classifier.predict(features); }, refused);
}

TEST(FeatureEmbedding, ImagesThatAreAllAlikeTeachNothing) {
  EXPECT_FALSE(learned(oneWord(std::vector<float>(8, 0.3F))).embedding().isInformative());
  EXPECT_TRUE(learned(madeUpRooms(3, 20, 1)).embedding().isInformative());
}

TEST(FeatureEmbedding, PartsThatAreAllAlikeHaveNoShare) {
  Features features = madeUpRooms(3, 20, 1);
  DescriptorMatrix values(18);
  for (std::size_t i = 0; i < features.values.size(); ++i) {
    std::vector<float> row(features.values.row(i).begin(), features.values.row(i).end());
    std::fill(row.begin(), row.begin() + 12, 1.0F / 12);
    values.append(row);
  }
  features.values = values;
  const DescriptorMatrix x = FeatureEmbedding::learn(features).apply(features);
  double norm = 0;
  for (const float v : x.values()) norm += static_cast<double>(v) * v / static_cast<double>(x.size());
  EXPECT_NEAR(norm, 1, 1e-4);
}

// ---- selection

TEST(Selection, FindsTheColumnsThatTell) {
  const Features features = madeUpRooms(3, 40, 1, 12, 6);  // bins 0 … 2 tell of the rooms, 3 … 5 do not
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
  EXPECT_THAT([&] { selectColumns(features, "mean", 19); }, FailsWith(ErrorCode::invalidInput, "19", "18"));
  EXPECT_THAT([&] { selectColumns(features, "mean", 0); }, FailsWith(ErrorCode::invalidInput, "0", "18"));
  EXPECT_THAT([&] { selectColumns(features, "size", 2); },
              FailsWith(ErrorCode::unknownName, "size", "mean, mutual-information, chi2"));
  EXPECT_THAT([&] { withColumns(features, {18}); }, FailsWith(ErrorCode::invalidInput, "18", "17"));
  EXPECT_THAT([&] { withColumns(features, {}); }, FailsWith(ErrorCode::invalidInput, "17"));
}

// ---- scores

TEST(Scores, ConfusionCountsWhatWasTakenForWhat) {
  const Confusion confusion = confusionOf({"a", "a", "a", "b", "c"}, {"a", "b", "a", "b", "d"});
  EXPECT_EQ(confusion.rooms, (std::vector<std::string>{"a", "b", "c", "d"}));
  EXPECT_EQ(confusion.counts[0], (std::vector<std::size_t>{2, 1, 0, 0}));
  EXPECT_DOUBLE_EQ(confusion.accuracy(), 0.6);
  EXPECT_DOUBLE_EQ(confusion.balancedAccuracy(), (2.0 / 3 + 1 + 0) / 3);
  EXPECT_THAT([] { confusionOf({}, {}); }, FailsWith(ErrorCode::mismatch, "0"));
  EXPECT_THAT([] { confusionOf({"a"}, {}); }, FailsWith(ErrorCode::mismatch, "1", "0"));
}

TEST(Scores, ARoomNeverLearnedCanOnlyBeWrong) {
  const RoomClassifier classifier = learned(madeUpRooms(3, 10, 1));
  const Confusion confusion = testRooms(classifier, madeUpRooms(4, 10, 2));
  EXPECT_EQ(confusion.counts[3][3], 0U);
  EXPECT_EQ(confusion.total(), 40U);
  EXPECT_LE(confusion.accuracy(), 0.75);
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

}  // namespace
}  // namespace estancia
