// What answers are worth: shares with intervals, confusions, corrected choices.
// SPDX-License-Identifier: Apache-2.0
#include "scenes/scene_answers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/stats/proportion.hpp"
#include "scenes/scenes_statistics.hpp"
#include "scenes/scenes_subsets.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

/// `runs` runs of `length` images, rooms in turn.
SceneTest testOf(int runs, int length, int rooms = 2) {
  SceneTest test;
  test.roomCount = rooms;
  test.runCount = runs;
  for (int i = 0; i < runs * length; ++i) {
    test.runs.push_back(i / length);
    test.rooms.push_back(i / length % rooms);
  }
  return test;
}

TEST(SceneShare, OfIndependentImagesIsWilsonsInterval) {
  const Share share = shareRight(testOf(10, 1), {1, 1, 1, 1, 1, 1, 1, 1, 0, 0});
  EXPECT_DOUBLE_EQ(share.value, 0.8);
  // Wilson's interval with 9 · (1.95996 / 2.26216)² images: ten runs leave nine degrees of freedom.
  const auto [low, high] = wilsonInterval(0.8, 9 * std::pow(1.95996398 / 2.26215716, 2));
  EXPECT_NEAR(share.low, low, 1e-7);
  EXPECT_NEAR(share.high, high, 1e-7);
}

TEST(SceneShare, IntervalsOfFewRunsCoverTheTrueShare) {
  // Runs of 20 images each; a run's own share of right answers is uniform between 0.4 and 1.
  std::mt19937_64 random(11);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) / 9007199254740992.0; };
  for (const int runs : {4, 5, 10, 30}) {
    const SceneTest test = testOf(runs, 20);
    int covered = 0;
    for (int trial = 0; trial < 4000; ++trial) {
      std::vector<double> right;
      for (int r = 0; r < runs; ++r) {
        const double share = 0.4 + 0.6 * uniform();
        for (int i = 0; i < 20; ++i) right.push_back(uniform() < share ? 1 : 0);
      }
      const Share found = shareRight(test, right);
      covered += found.low <= 0.7 && 0.7 <= found.high ? 1 : 0;
    }
    EXPECT_GE(covered, 0.94 * 4000) << runs << " runs";
  }
}

TEST(SceneShare, ImagesOfARunAreOneWitness) {
  std::vector<double> right(100);
  for (std::size_t i = 0; i < right.size(); ++i) right[i] = i / 10 < 8 ? 1 : 0;  // whole runs right or wrong
  const Share together = shareRight(testOf(10, 10), right);
  const Share independent = shareRight(testOf(10, 1), {1, 1, 1, 1, 1, 1, 1, 1, 0, 0});
  EXPECT_NEAR(together.low, independent.low, 1e-12);
  EXPECT_NEAR(together.high, independent.high, 1e-12);
  for (std::size_t i = 0; i < right.size(); ++i) right[i] = i % 10 < 8 ? 1 : 0;  // equal in every run
  const Share spread = shareRight(testOf(10, 10), right);
  EXPECT_GT(spread.low, together.low + 0.1);
  EXPECT_LT(spread.high, together.high - 0.05);
}

TEST(SceneShare, AllRightIsNoCertainty) {
  const Share all = shareRight(testOf(10, 5), std::vector<double>(50, 1));
  EXPECT_EQ(all.value, 1);
  EXPECT_EQ(all.high, 1);
  EXPECT_NEAR(all.low, 10 / (10 + 3.8415), 1e-4) << "Wilson's of ten in ten runs";
  const Share none = shareRight(testOf(10, 5), std::vector<double>(50, 0));
  EXPECT_EQ(none.low, 0);
  EXPECT_NEAR(none.high, 1 - all.low, 1e-12);
  const Share single = shareRight(testOf(1, 5), {1, 1, 0, 1, 0});
  EXPECT_LT(single.low, 0.2) << "one run tells little";
  EXPECT_GT(single.high, 0.9);
}

TEST(SceneShare, NeedsImages) {
  EXPECT_THAT([] { shareRight({}, {}); }, FailsWith(ErrorCode::insufficientData));
}

TEST(SceneAnswers, CountConfusionsAsAMeanOverSeeds) {
  const SceneTest test{{0, 0, 1, 2}, {0, 0, 1, 2}, 4, 3};
  const SceneAnswers answers{{{0, 1, 1, 3}, {0, 0, 1, 1}}};
  EXPECT_THAT(answers.right(test), ElementsAre(1, 0.5, 1, 0));
  EXPECT_THAT(answers.confusion(test), ElementsAre(1.5, 0.5, 0, 0, 0, 1, 0, 0, 0, 0.5, 0, 0.5, 0, 0, 0, 0));
  EXPECT_DOUBLE_EQ(answers.balancedAccuracy(test), (0.75 + 1 + 0) / 3) << "room 3 is not asked about";
  EXPECT_THAT(answers.rightInRuns(test), ElementsAre(3, 2, 0));
}

TEST(SceneAnswers, ReadBackWhatTheyTold) {
  const SceneTest test{{0, 0, 1, 2}, {0, 0, 1, 2}, 4, 3};
  const SceneAnswers answers{{{0, 1, 1, 3}, {0, 0, 1, 1}}};
  CellResults results = answers.toResults(test);
  EXPECT_EQ(results[0].measure, "accuracy");
  EXPECT_DOUBLE_EQ(results[0].value, 0.625);
  EXPECT_EQ(SceneAnswers::fromResults(results, test, 2).answers, answers.answers);
  EXPECT_THAT([&] { SceneAnswers::fromResults(results, test, 3); },
              FailsWith(ErrorCode::corruptFile, "`cells`"));
  results.back().value = 4;
  EXPECT_THAT([&] { SceneAnswers::fromResults(results, test, 2); },
              FailsWith(ErrorCode::corruptFile, "`cells`"));
}

/// One descriptor, as many classifiers as there are shares: each right about that share of the images.
ScenesResults guesses(int runs, const std::vector<double>& shares) {
  ScenesResults results;
  results.rooms = {"a", "b"};
  results.descriptors = {{"words", true, 1}};
  auto& pair =
      results.pairs.emplace_back(ScenesResults::Pair{"train", "test", testOf(runs, 2), {}, {}, 9, false});
  for (std::size_t i = 0; i < pair.images.rooms.size(); ++i) pair.names.push_back(std::to_string(i));
  for (int r = 0; r < runs; ++r) pair.runs.push_back("run " + std::to_string(r));
  std::mt19937 random(7);
  for (std::size_t c = 0; c < shares.size(); ++c) {
    results.classifiers.push_back(std::to_string(c));
    auto& answers = results.cells.emplace_back().answers.emplace_back(pair.images.rooms);
    for (int& answer : answers)
      if (static_cast<double>(random()) / 4294967296.0 >= shares[c]) answer = 1 - answer;
  }
  return results;
}

TEST(SceneChoice, TheBestOfManyEqualsIsWorthWhatTheyAllAre) {
  const ScenesResults results = guesses(60, std::vector<double>(80, 0.6));
  std::vector<std::size_t> cells(80);
  for (std::size_t c = 0; c < cells.size(); ++c) cells[c] = c;
  const auto means = meanAccuracies(results, cells);
  const double plain = *std::max_element(means.begin(), means.end());
  const double corrected = accuracyOfChoice(results, cells, 1);
  EXPECT_GT(plain, 0.66) << "by luck";
  EXPECT_LT(corrected, 0.61);
  EXPECT_GT(corrected, 0.55);
  EXPECT_EQ(accuracyOfChoice(results, cells, 1), corrected);
  EXPECT_NEAR(accuracyOfChoice(results, cells, 2), corrected, 0.01);
}

TEST(SceneChoice, AClearWinnerKeepsItsValue) {
  const ScenesResults results = guesses(60, {0.95, 0.5, 0.5, 0.5});
  const auto means = meanAccuracies(results, {0, 1, 2, 3});
  const double corrected = accuracyOfChoice(results, {0, 1, 2, 3}, 1);
  EXPECT_NEAR(corrected, means[0], 0.005);
  EXPECT_LE(corrected, means[0]);
}

TEST(SceneChoice, IsAMeanOverPairsAsThePlainFigure) {
  // Two cells of the same answers: right about all of 50 images, and about every other one of 500.
  ScenesResults results;
  results.rooms = {"a", "b"};
  results.descriptors = {{"words", true, 1}};
  results.classifiers = {"1", "2"};
  for (const int runs : {10, 100}) {
    auto& pair = results.pairs.emplace_back(
        ScenesResults::Pair{"train", std::to_string(runs), testOf(runs, 5, 1), {}, {}, 9, false});
    for (int r = 0; r < runs; ++r) pair.runs.push_back(std::to_string(r));
    SceneAnswers answers{{pair.images.rooms}};
    if (runs == 100)
      for (std::size_t i = 0; i < 500; ++i) answers.answers[0][i] = i / 5 % 2 == 0 ? 0 : 1;
    results.cells.insert(results.cells.end(), 2, answers);
  }
  EXPECT_THAT(meanAccuracies(results, {0, 1}), ElementsAre(0.75, 0.75));
  EXPECT_NEAR(accuracyOfChoice(results, {0, 1}, 1), 0.75, 0.005);
}

TEST(SceneChoice, AmongEqualsIsNotTheLuckyOne) {
  // On runs drawn of three, cells are often equally good: the first of them is no better choice than the
  // last.
  const auto choice = [](const std::vector<std::vector<int>>& right) {
    ScenesResults results;
    results.rooms = {"a", "b"};
    results.descriptors = {{"words", true, 1}};
    auto& pair = results.pairs.emplace_back(
        ScenesResults::Pair{"train", "test", testOf(3, 3, 1), {}, {"0", "1", "2"}, 9, false});
    std::vector<std::size_t> cells;
    for (const auto& counts : right) {
      cells.push_back(cells.size());
      results.classifiers.push_back(std::to_string(cells.size()));
      auto& answers = results.cells.emplace_back().answers.emplace_back(pair.images.rooms);
      for (std::size_t i = 0; i < answers.size(); ++i)
        answers[i] = static_cast<int>(i % 3) < counts[i / 3] ? 0 : 1;
    }
    return accuracyOfChoice(results, cells, 1);
  };
  const double one = choice({{3, 1, 2}, {2, 2, 1}, {1, 3, 1}}),
               other = choice({{1, 3, 1}, {2, 2, 1}, {3, 1, 2}});
  EXPECT_NEAR(one, other, 1e-12) << "the order of cells says nothing";
}

TEST(SceneBlocks, AreRunsOfOneTestAndPairsOfMany) {
  ScenesResults results = guesses(10, {0.9, 0.6});
  const SceneBlocks runs = blocksOf(results);
  EXPECT_TRUE(runs.runs);
  ASSERT_EQ(runs.right.size(), 10U);
  EXPECT_EQ(runs.names[3], "train→test: run 3");
  const auto counts = results.cells[1].rightInRuns(results.pairs[0].images);
  for (std::size_t r = 0; r < 10; ++r) EXPECT_EQ(runs.right[r][1], counts[r]);
  EXPECT_THAT(runs.answers, Each(2));

  // Beside another test, a pair of a sequence with itself carries no information about runs.
  results.pairs.push_back(results.pairs[0]);
  results.pairs[1].same = true;
  results.pairs[1].train = "test";
  results.cells.insert(results.cells.end(), {results.cells[0], results.cells[1]});
  EXPECT_EQ(blocksOf(results).right.size(), 10U);

  while (results.pairs.size() < minPairs) {
    results.pairs.push_back(results.pairs[0]);
    results.pairs.back().train = "train " + std::to_string(results.pairs.size());
    results.cells.insert(results.cells.end(), {results.cells[0], results.cells[1]});
  }
  const SceneBlocks pairs = blocksOf(results);
  EXPECT_FALSE(pairs.runs);
  ASSERT_EQ(pairs.right.size(), minPairs);
  EXPECT_EQ(pairs.names[1], "test→test");
  EXPECT_DOUBLE_EQ(scoresOfCells(results, pairs).values[2][0], meanAccuracies(results, {0})[0]);
}

TEST(SceneScores, AreMeansOverTheOther) {
  ScenesResults results = guesses(4, {0.9, 0.6, 0.7, 0.2});
  results.descriptors = {{"words", true, 1}, {"gist", false, 1}};
  results.classifiers = {"svm", "knn"};
  const SceneBlocks blocks = blocksOf(results);
  const MethodScores cells = scoresOfCells(results, blocks),
                     descriptors = scoresOfDescriptors(results, blocks),
                     classifiers = scoresOfClassifiers(results, blocks);
  EXPECT_THAT(cells.methods, ElementsAre("words/svm", "words/knn", "gist/svm", "gist/knn"));
  EXPECT_THAT(descriptors.methods, ElementsAre("words", "gist"));
  EXPECT_THAT(classifiers.methods, ElementsAre("svm", "knn"));
  for (std::size_t b = 0; b < 4; ++b) {
    const auto& block = cells.values[b];
    EXPECT_DOUBLE_EQ(descriptors.values[b][1], (block[2] + block[3]) / 2);
    EXPECT_DOUBLE_EQ(classifiers.values[b][0], (block[0] + block[2]) / 2);
  }
}

TEST(SceneSubsets, AllLabelsAreSpokenOfWhenTheyWereTried) {
  ScenesResults results = guesses(60, {0.9, 0.6});
  results.curveDescriptor = "words";
  results.curveClassifier = "knn";
  results.counts = {75, 300};
  results.curves.push_back({"mean", {{results.cells[0]}, {results.cells[1]}}});
  results.labels = 793;
  EXPECT_EQ(subsetAnswer(results), "") << "300 labels are not all of them";
  results.labels = 300;
  EXPECT_THAT(subsetAnswer(results), HasSubstr("holds here: against all 300"));
}

TEST(SceneScores, EqualSharesAreEqual) {
  // One run of ten images; of the first descriptor's five classifiers 2, 5, 6, 7, 9 answers are right, and as
  // many of the others' in other orders.
  ScenesResults results;
  results.rooms = {"a", "b"};
  results.classifiers = {"1", "2", "3", "4", "5"};
  results.pairs.push_back({"train", "test", testOf(1, 10), {}, {"run"}, 9, false});
  std::vector<int> right{2, 5, 6, 7, 9};
  do {
    results.descriptors.push_back({std::to_string(results.descriptors.size()), true, 1});
    for (const int count : right) {
      auto& cell = results.cells.emplace_back();
      for (const int more : {0, 1, 0}) {  // three seeds, one of which knows one image more
        cell.answers.push_back(results.pairs[0].images.rooms);
        for (int i = count + more; i < 10; ++i) cell.answers.back()[static_cast<std::size_t>(i)] = 1;
      }
    }
  } while (std::next_permutation(right.begin(), right.end()));
  ASSERT_EQ(results.descriptors.size(), 120U);
  const MethodScores descriptors = scoresOfDescriptors(results, blocksOf(results));
  EXPECT_THAT(descriptors.values[0], Each((3 * 29 + 5) / 150.0));
  const MethodScores classifiers = scoresOfClassifiers(results, blocksOf(results));
  EXPECT_THAT(classifiers.values[0], Each((3 * 29 + 5) / 150.0));
}

}  // namespace
}  // namespace estancia::experiments
