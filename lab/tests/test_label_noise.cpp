// SPDX-License-Identifier: Apache-2.0
#include "objects/label_noise.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "objects/made_up.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::madeUpThings;
using test::MadeUpThings;
using test::rows;
using test::saying;
using testing::Each;

TEST(Noise, SwapsAsManyAsAsked) {
  std::vector<int> words, instances;
  for (int i = 0; i < 100; ++i) {
    words.push_back(i % 4);
    instances.push_back(i / 10);
  }
  const ClassProbabilities said = saying(words, 4);
  const auto changed = [&](NoiseKind kind, double rate, std::uint64_t seed) {
    const ClassProbabilities noisy = withNoise(said, kind, rate, instances, seed);
    std::set<std::size_t> rows;
    for (std::size_t i = 0; i < words.size(); ++i) {
      std::vector<float> before(said.probabilities.row(i).begin(), said.probabilities.row(i).end()),
          after(noisy.probabilities.row(i).begin(), noisy.probabilities.row(i).end());
      if (test::best(after) != words[i]) rows.insert(i);
      if (kind == NoiseKind::pair && rows.contains(i)) {
        EXPECT_EQ(test::best(after), (words[i] + 1) % 4);
      }
      std::ranges::sort(before);
      std::ranges::sort(after);
      EXPECT_EQ(before, after) << "the distribution is another";
    }
    EXPECT_EQ(noisy.coverage, said.coverage);
    return rows;
  };
  for (const NoiseKind kind : {NoiseKind::view, NoiseKind::pair}) {
    EXPECT_EQ(changed(kind, 0, 1).size(), 0U);
    EXPECT_EQ(changed(kind, 0.2, 1).size(), 20U);
    EXPECT_EQ(changed(kind, 1, 1).size(), 100U);
    EXPECT_EQ(changed(kind, 0.2, 1), changed(kind, 0.2, 1));
    EXPECT_NE(changed(kind, 0.2, 1), changed(kind, 0.2, 2));
    EXPECT_TRUE(std::ranges::includes(changed(kind, 0.4, 1), changed(kind, 0.2, 1)));
  }
  EXPECT_THAT([&] { withNoise(said, NoiseKind::view, 1.5, instances, 1); },
              FailsWith(ErrorCode::invalidOption, "1.5"));
}

TEST(Noise, MisnamesWholeThingsAlike) {
  std::vector<int> instances(100);
  for (int i = 0; i < 100; ++i) instances[static_cast<std::size_t>(i)] = i / 10;
  std::vector<int> words(100, 1);
  words[3] = 2;  // the labeler was wrong about one view
  const ClassProbabilities noisy = withNoise(saying(words, 4), NoiseKind::instance, 0.3, instances, 4);
  int misnamed = 0;
  for (std::size_t thing = 0; thing < 10; ++thing) {
    std::set<int> called;
    for (std::size_t i = 10 * thing; i < 10 * thing + 10; ++i)
      if (i != 3) called.insert(test::best(noisy.probabilities.row(i)));
    EXPECT_EQ(called.size(), 1U);
    misnamed += *called.begin() != 1 ? 1 : 0;
  }
  EXPECT_EQ(misnamed, 3);
}

TEST(Noise, WhereNothingIsSaidNothingIsSwapped) {
  const ClassProbabilities said{rows({{0, 0, 0}, {0.2F, 0.7F, 0.1F}, {0, 0, 0}}), {0, 1, 0}};
  const std::vector<int> instances{0, 0, 1};
  for (const NoiseKind kind : {NoiseKind::view, NoiseKind::pair}) {
    const ClassProbabilities noisy = withNoise(said, kind, 1, instances, 1);
    EXPECT_THAT(noisy.probabilities.row(0), Each(0));
    EXPECT_NE(test::best(noisy.probabilities.row(1)), 1);
  }
  const ClassProbabilities one{rows({{1}, {1}}), {1, 1}};
  EXPECT_EQ(withNoise(one, NoiseKind::view, 1, {}, 1).probabilities.values(), one.probabilities.values());
  EXPECT_EQ(withNoise({DescriptorMatrix(3), {}}, NoiseKind::instance, 0.5, {}, 1).probabilities.size(), 0U);
}

/// What the vote is for: independent errors about single views do not reach the classifier.
TEST(Names, TheVoteWithstandsNoiseThatTopDoesNot) {
  const int words = 12;
  const test::Manner manner{24, 0.3, 1.0};
  const MadeUpThings train = madeUpThings(words, 1, 10, 1, manner),
                     asked = madeUpThings(words, 1, 40, 2, manner);
  const auto accuracy = [&](PseudoLabeling naming, double rate, std::uint64_t seed) {
    ClassifierOptions options;
    options.c = 10;
    options.gamma = 1;
    const ClassProbabilities said =
        withNoise(saying(train.classes, words), NoiseKind::view, rate, train.instances, seed);
    const ObjectTraining training{test::madeUpStudy(words),
                                  {},
                                  train.shapes,
                                  assignPseudoLabels(naming, said, train.instances, train.shapes, options),
                                  train.instances,
                                  "",
                                  {}};
    return test::shareRight(trainObjectModel(training, options).predict(asked.shapes), asked.classes);
  };
  double topLoses = 0, votedLoses = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    topLoses += (accuracy(PseudoLabeling::top, 0, seed) - accuracy(PseudoLabeling::top, 0.2, seed)) / 3;
    votedLoses += (accuracy(PseudoLabeling::voted, 0, seed) - accuracy(PseudoLabeling::voted, 0.2, seed)) / 3;
  }
  EXPECT_LE(votedLoses, 0.05);
  EXPECT_GT(topLoses, 0.05);
}

}  // namespace
}  // namespace estancia::experiments
