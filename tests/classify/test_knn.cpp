// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "samples.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::accuracy;
using test::bytesOf;
using test::changed;
using test::clouds;
using test::FailsWith;
using test::trained;
using test::typed;

TEST(Knn, IsWhatBruteForceFinds) {
  const Samples samples = clouds(4, 57, 33, 2, 1), queries = clouds(4, 50, 33, 2, 2);
  for (const int k : {1, 4, 9, 228, 500}) {
    ClassifierOptions options = typed("knn");
    options.neighbors = k;
    options.metric = "euclidean";
    const DescriptorMatrix p = trained(samples, options)->predict(queries.x);
    for (std::size_t i = 0; i < queries.x.size(); ++i) {
      std::vector<std::pair<double, std::size_t>> all;
      for (std::size_t j = 0; j < samples.x.size(); ++j) {
        double sum = 0;
        for (std::size_t c = 0; c < 33; ++c) {
          const double d = static_cast<double>(queries.x.row(i)[c]) - samples.x.row(j)[c];
          sum += d * d;
        }
        all.emplace_back(std::sqrt(sum), j);
      }
      std::sort(all.begin(), all.end());
      std::vector<double> votes(4);
      double sum = 0;
      for (std::size_t n = 0; n < std::min<std::size_t>(static_cast<std::size_t>(k), all.size()); ++n) {
        votes[static_cast<std::size_t>(samples.classes[all[n].second])] += 1 / all[n].first;
        sum += 1 / all[n].first;
      }
      for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(p.row(i)[c], votes[c] / sum, 1e-5) << k << " " << i;
    }
  }
}

TEST(Knn, TheCosineIgnoresLengths) {
  const Samples samples = clouds(3, 20, 5, 1, 1);
  ClassifierOptions options = typed("knn");
  options.neighbors = 5;
  options.metric = "cosine";
  Samples longer = samples;
  longer.x = DescriptorMatrix(5);
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    std::vector<float> row(samples.x.row(i).begin(), samples.x.row(i).end());
    for (float& value : row) value *= static_cast<float>(1U << (i % 5));  // exact in float32
    longer.x.append(row);
  }
  EXPECT_EQ(trained(longer, options)->predict(samples.x).values(),
            trained(samples, options)->predict(longer.x).values());
}

TEST(Knn, TheCosineIsReadBackExactly) {
  const Samples samples = clouds(3, 20, 31, 2, 1), queries = clouds(3, 20, 31, 2, 2);
  ClassifierOptions options = typed("knn");
  options.metric = "cosine";
  const auto classifier = trained(samples, options);
  const std::string bytes = bytesOf(*classifier);
  ByteReader in(bytes, "bytes", "look again");
  const auto back = readClassifier(in);
  EXPECT_EQ(bytesOf(*back), bytes);
  EXPECT_EQ(back->predict(queries.x).values(), classifier->predict(queries.x).values());
}

TEST(Knn, ASampleItselfOutvotesAllOthers) {
  const Samples samples = clouds(3, 20, 5, 3, 1);
  ClassifierOptions options = typed("knn");
  options.neighbors = 9;
  const DescriptorMatrix p = trained(samples, options)->predict(samples.x);
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_EQ(p.row(i)[static_cast<std::size_t>(samples.classes[i])], 1);
}

TEST(Knn, TheOriginMayBeFarAway) {
  // Values are rounded to what float32 holds out there, so that distances are the same.
  const Samples far = changed(clouds(4, 60, 5, 2, 1), 1000, 1),
                farQueries = changed(clouds(4, 60, 5, 2, 2), 1000, 1);
  const Samples near = changed(far, -1000, 1), queries = changed(farQueries, -1000, 1);
  for (const int k : {0, 3}) {
    ClassifierOptions options = typed("knn");
    options.metric = "euclidean";
    if (k > 0) options.neighbors = k;
    const auto classifier = trained(far, options), expected = trained(near, options);
    EXPECT_EQ(classifier->choice(), expected->choice());
    EXPECT_EQ(classifier->predict(farQueries.x).values(), expected->predict(queries.x).values());
  }
}

TEST(Knn, NumbersTooLargeForDistancesAreRefused) {
  const Samples good = clouds(2, 10, 4, 1, 1), huge = changed(good, 0, 1e20F);
  for (const char* metric : {"euclidean", "cosine"}) {
    ClassifierOptions options = typed("knn");
    options.metric = metric;
    const auto classifier = trained(good, options);
    EXPECT_THAT([&] { trained(huge, options); }, FailsWith(ErrorCode::invalidInput, "float32"));
    EXPECT_THAT([&] { classifier->predict(huge.x); }, FailsWith(ErrorCode::invalidInput, "float32"));
  }
}

/// "1 neighbors, cosine: 75.0 % of held-out samples" → 75.
double heldOutShare(const Classifier& classifier) {
  const std::string choice = classifier.choice();
  return std::stod(choice.substr(choice.find(": ") + 2));
}

/// Class 0 is zeros, which have no direction, class 1 short and long rows of one: the nearest of each is its
/// own.
TEST(Knn, TheSearchMeasuresAsThePredictionDoes) {
  Samples samples{DescriptorMatrix(2), {}, {}, 2};
  for (int i = 0; i < 40; ++i) {
    const int c = i % 2;
    const auto length = static_cast<float>(c * (i + 1));
    samples.x.append(std::vector<float>{3 * length, 4 * length});
    samples.classes.push_back(c);
    samples.groups.push_back(i);
  }
  ClassifierOptions options = typed("knn");
  options.neighbors = 1;
  options.metric = "cosine";
  const auto classifier = trained(samples, options);
  EXPECT_EQ(accuracy(*classifier, samples), 1);
  EXPECT_EQ(heldOutShare(*classifier), 100);
}

/// Twins are at distance 0, and outvote all others, wherever they lie.
TEST(Knn, TheSearchFindsTwins) {
  Samples samples = clouds(2, 30, 9, 0.001, 1);
  DescriptorMatrix x(9);
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    std::vector<float> row(samples.x.row(i / 2 * 2).begin(), samples.x.row(i / 2 * 2).end());
    for (float& value : row) value += 30;
    x.append(row);
    samples.classes[i] = static_cast<int>(i / 2 % 2);  // nothing but its twin tells of a sample
    samples.groups[i] = static_cast<int>(i);
  }
  samples.x = x;
  ClassifierOptions options = typed("knn");
  options.neighbors = 25;
  options.metric = "euclidean";
  options.folds = 60;
  EXPECT_EQ(heldOutShare(*trained(samples, options)), 100);
}

}  // namespace
}  // namespace estancia
