// Rooms by their names alone; and classifiers beside those of scikit-learn.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/zero_shot_rooms.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/words/room_words.hpp"
#include "samples.hpp"
#include "support/errors.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;
using test::FailsWith;
using test::realWords;

const std::vector<std::string> labels = {"stove",   "toaster", "four-poster", "pillow",
                                         "bathtub", "towel",   "zebra"};
const std::vector<std::string> rooms = {"kitchen", "bedroom", "bathroom"};

/// Images of which each shows one label, .7 of it.
DescriptorMatrix imagesOf(const std::vector<std::size_t>& shown) {
  DescriptorMatrix images(labels.size());
  for (const std::size_t label : shown) {
    std::vector<float> row(labels.size(), 0.001F);
    row[label] = 0.7F;
    images.append(row);
  }
  return images;
}

RoomPredictions predictionsOf(const std::vector<std::vector<float>>& rows) {
  RoomPredictions predictions{"test", rooms, DescriptorMatrix(rooms.size())};
  for (const std::vector<float>& row : rows) predictions.probabilities.append(row);
  return predictions;
}

std::vector<std::string> bestRooms(const RoomPredictions& predictions) {
  std::vector<std::string> best;
  for (std::size_t i = 0; i < predictions.probabilities.size(); ++i)
    best.push_back(rankedRooms(predictions, i).front().room);
  return best;
}

RoomPredictions predicted(const DescriptorMatrix& images, const std::vector<std::string>& listed) {
  return predictRoomsByNames(realWords(), Vocabulary(labels), images, listed);
}

TEST(ZeroShotRooms, FollowFromWhatLabelsHaveToDoWithTheirNamesOrThoseOfCommonOnes) {
  const RoomPredictions predictions = predicted(imagesOf({0, 1, 2, 3, 4, 5}), rooms);
  EXPECT_THAT(bestRooms(predictions),
              testing::ElementsAre("kitchen", "kitchen", "bedroom", "bedroom", "bathroom", "bathroom"));
  for (std::size_t i = 0; i < 6; ++i) {
    const DescriptorView row = predictions.probabilities.row(i);
    EXPECT_NEAR(std::accumulate(row.begin(), row.end(), 0.0), 1, 1e-5);
  }
  EXPECT_TRUE(predictions.areByName);
  EXPECT_TRUE(predictions.areListed);
  const RoomPredictions common = predicted(imagesOf({0, 0, 3, 4}), {});
  EXPECT_EQ(common.rooms, commonRooms());
  EXPECT_FALSE(common.areListed);
  EXPECT_THAT(bestRooms(common), testing::ElementsAre("kitchen", "kitchen", "bedroom", "bathroom"));
}

TEST(ZeroShotRooms, NeedRoomsThatHaveEnglishNames) {
  const DescriptorMatrix images = imagesOf({0});
  EXPECT_TRUE(knowsRooms(realWords(), {"kitchen", "living_room"}));
  EXPECT_FALSE(knowsRooms(realWords(), {"kitchen", "xyzzy"}));
  EXPECT_THAT([&] { predicted(images, {"kitchen", "xyzzy"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { predicted(images, {"kitchen", ""}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { predicted(images, {"kitchen"}); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { predictRoomsByNames(realWords(), Vocabulary({"stove"}), images, rooms); },
              FailsWith(ErrorCode::mismatch));
}

TEST(RoomWords, ListsOfRoomsAreReadAsPeopleWriteThem) {
  EXPECT_THAT(listedRooms({"kitchen", " living room", "Kitchens", "Bath\t"}),
              testing::ElementsAre("kitchen", "living room", "Bath"));
  EXPECT_TRUE(listedRooms({}).empty());
  for (const char* wrong : {"", "  ", "---", "kit\x1B[31mchen", "\xFF"})
    EXPECT_THAT([&] { listedRooms({"kitchen", wrong}); }, FailsWith(ErrorCode::invalidOption));
}

TEST(RoomWords, WeighLabelsByRoomsAndTheirFurnishings) {
  const auto weights = roomLabelWeights(realWords(), Vocabulary({"stove", "studio couch", "altar"}),
                                        {"kitchen", "Living_Rooms", "church"});
  EXPECT_GT(weights[0][0], 0);
  EXPECT_GT(weights[1][1], weights[0][1]) << "a sofa is a living room's";
  EXPECT_EQ(weights[0][2], 0);
  EXPECT_GT(weights[2][2], 0) << "a room that is not common is told by its name alone";
  EXPECT_EQ(findCommonRoom("living_rooms")->name, "living room");
  EXPECT_EQ(findCommonRoom("church"), nullptr);
  EXPECT_EQ(findCommonRoom("sitting room"), nullptr);
  EXPECT_EQ(findCommonRoom(realWords(), "sitting room")->name, "living room");
  for (const char* none : {"church", "chair", "room", "xyzzy", ""})
    EXPECT_EQ(findCommonRoom(realWords(), none), nullptr) << none;
}

TEST(NamesAsPrior, CountLessWithEachExampleAndAreOfTheSameImagesAndRooms) {
  for (const auto& [examples, share] : {std::pair{0, 1.0}, {10, 0.75}, {40, 0.0}, {1000, 0.0}})
    EXPECT_EQ(shareOfNames(examples), share) << examples;
  const RoomPredictions one = predictionsOf({{1, 0, 0}}), two = predictionsOf({{1, 0, 0}, {0, 1, 0}});
  EXPECT_THAT([&] { withNames(one, two, 0.5); }, FailsWith(ErrorCode::mismatch));
  RoomPredictions others = one;
  others.rooms.back() = "attic";
  EXPECT_THAT([&] { withNames(one, others, 0.5); }, FailsWith(ErrorCode::mismatch));
}

TEST(NamesAsPrior, DecideWhatExamplesLeaveOpen) {
  const RoomPredictions trained =
      predictionsOf({{0.4F, 0.4F, 0.2F}, {0.9F, 0.05F, 0.05F}, {0, 0, 0}, {0, 1, 0}});
  const RoomPredictions byNames =
      predictionsOf({{0.2F, 0.6F, 0.2F}, {0.3F, 0.4F, 0.3F}, {0.8F, 0.1F, 0.1F}, {1, 0, 0}});
  const RoomPredictions both = withNames(trained, byNames, 0.5);
  EXPECT_EQ(rankedRooms(both, 0).front().room, "bedroom") << "as probable by examples, more by name";
  EXPECT_EQ(rankedRooms(both, 1).front().room, "kitchen") << "the examples are sure";
  EXPECT_TRUE(rankedRooms(both, 2).empty()) << "nothing was predicted";
  EXPECT_EQ(rankedRooms(both, 3).front().room, "bedroom") << "half of the names' evidence";
  // 0.4 √0.2, 0.4 √0.6, 0.2 √0.2, divided by their sum
  EXPECT_NEAR(both.probabilities.row(0)[1], 0.3098 / (0.1789 + 0.3098 + 0.0894), 1e-3);
  const RoomPredictions alone = withNames(trained, byNames, 0);
  for (std::size_t r = 0; r < rooms.size(); ++r)
    EXPECT_NEAR(alone.probabilities.row(0)[r], trained.probabilities.row(0)[r], 1e-6);
}

constexpr int classCount = 4;
constexpr std::size_t columns = 6;

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 40) / 0x1p24;
  }

 private:
  std::uint64_t state_;
};

Samples samplesOf(std::uint64_t seed, int count) {
  Random random(seed), center(99);
  std::vector<std::vector<double>> centers(classCount, std::vector<double>(columns));
  for (auto& of : centers)
    for (double& v : of) v = center.uniform();
  Samples samples{DescriptorMatrix(columns), {}, {}, classCount};
  for (int i = 0; i < count; ++i) {
    const int c = std::min(i * i % 7, 3);
    std::vector<float> row;
    for (const double v : centers[static_cast<std::size_t>(c)])
      row.push_back(static_cast<float>(v + random.uniform()));
    samples.x.append(row);
    samples.classes.push_back(c);
    samples.groups.push_back(i);
  }
  return samples;
}

const Json& expected() {
  static const Json json =
      Json::parse(std::ifstream(std::string(ESTANCIA_SOURCE_DIR) + "/tests/classify/sklearn_classify.json"));
  return json;
}

/// Decision values by plain loops over what the classifier writes to its file.
std::vector<double> decisions(const Classifier& classifier, DescriptorView x) {
  const std::string bytes = test::bytesOf(classifier);
  ByteReader in = test::afterHead(bytes);
  const auto gamma = in.number<double>();
  const auto starts = in.numbers<std::uint64_t>();
  const auto coefficients = in.numbers<double>();
  const auto rho = in.numbers<double>();
  in.raw(rho.size() * 2 * sizeof(double));
  const auto width = in.number<std::uint64_t>();
  const auto vectors = in.numbers<float>();
  const std::size_t k = starts.size() - 1;
  std::vector<double> f;
  for (std::size_t i = 0, p = 0; i < k; ++i)
    for (std::size_t j = i + 1; j < k; ++j, ++p) {
      double sum = -rho[p];
      const auto add = [&](std::size_t v, double coefficient) {
        double dot = 0, square = 0;
        for (std::size_t c = 0; c < width; ++c) {
          const double a = vectors[v * width + c];
          dot += a * x[c];
          square += (a - x[c]) * (a - x[c]);
        }
        sum += coefficient * (gamma > 0 ? std::exp(-gamma * square) : dot);
      };
      if (gamma == 0) {
        add(p, 1);
      } else {
        for (std::size_t v = starts[i]; v < starts[i + 1]; ++v) add(v, coefficients[v * (k - 1) + j - 1]);
        for (std::size_t v = starts[j]; v < starts[j + 1]; ++v) add(v, coefficients[v * (k - 1) + i]);
      }
      f.push_back(sum);
    }
  return f;
}

void expectDecisions(const char* key, const ClassifierOptions& options) {
  const auto classifier = test::trained(samplesOf(1, 160), options);
  const Samples queries = samplesOf(2, 40);
  for (std::size_t i = 0; i < queries.x.size(); ++i) {
    const std::vector<double> f = decisions(*classifier, queries.x.row(i));
    ASSERT_EQ(f.size(), 6U);
    // The solver stops within 1e-3 of the optimum.
    for (std::size_t p = 0; p < f.size(); ++p) EXPECT_NEAR(f[p], expected()[key][i][p].get<double>(), 5e-3);
  }
}

TEST(Sklearn, SvmDecisionsAreTheSame) {
  ClassifierOptions options = test::typed("svm-rbf");
  options.c = 3;
  options.gamma = 0.7;
  expectDecisions("svm", options);
  options.balanced = true;
  expectDecisions("svm_balanced", options);
  ClassifierOptions linear = test::typed("svm-linear");
  linear.c = 3;
  expectDecisions("linear_svm", linear);
}

void expectProbabilities(const char* key, const ClassifierOptions& options, double tolerance) {
  const DescriptorMatrix p = test::trained(samplesOf(1, 160), options)->predict(samplesOf(2, 40).x);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t c = 0; c < classCount; ++c)
      EXPECT_NEAR(p.row(i)[c], expected()[key][i][c].get<double>(), tolerance) << "sample " << i;
}

TEST(Sklearn, LogisticProbabilitiesAndVotesOfNeighborsAreTheSame) {
  ClassifierOptions options = test::typed("linear");
  options.c = 10;
  expectProbabilities("logistic", options, 0.02);
  ClassifierOptions votes = test::typed("knn");
  votes.neighbors = 7;
  votes.metric = "euclidean";
  expectProbabilities("knn", votes, 1e-5);
}

Features featuresOf(const Samples& samples, double step) {
  Features features{{{"words", PartKind::probabilities, {}, "words"}}, {}, DescriptorMatrix(columns)};
  for (std::size_t c = 0; c < columns; ++c) features.parts[0].columns.push_back(std::to_string(c));
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    Frame frame;
    frame.name = std::to_string(i);
    frame.room = std::to_string(samples.classes[i]);
    features.frames.push_back(frame);
    std::vector<float> row(samples.x.row(i).begin(), samples.x.row(i).end());
    for (float& v : row)
      if (step > 0) v = static_cast<float>(std::floor(v / step) * step);
    features.values.append(row);
  }
  return features;
}

TEST(Sklearn, SelectionScoresAreTheSame) {
  const Samples samples = samplesOf(1, 160);
  const std::vector<double> chi2 = columnScores(featuresOf(samples, 0), "chi2");
  const std::vector<double> information = columnScores(featuresOf(samples, 0.25), "mutual-information");
  for (std::size_t c = 0; c < columns; ++c) {
    EXPECT_NEAR(chi2[c], expected()["chi2"][c].get<double>(), 1e-5);
    EXPECT_NEAR(information[c], expected()["mutual_information"][c].get<double>(), 1e-8);
  }
}

TEST(Sklearn, BalancedAccuracyIsTheSame) {
  std::vector<std::string> truth, guesses;
  const Samples samples = samplesOf(2, 40);
  for (int i = 0; i < 40; ++i) {
    const int c = samples.classes[static_cast<std::size_t>(i)];
    truth.push_back(std::to_string(c));
    guesses.push_back(std::to_string((c + (i % 3 == 0 ? 1 : 0)) % classCount));
  }
  EXPECT_NEAR(confusionOf(truth, guesses).balancedAccuracy(), expected()["balanced_accuracy"].get<double>(),
              1e-12);
}

}  // namespace
}  // namespace estancia
