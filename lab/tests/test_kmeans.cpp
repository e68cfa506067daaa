// SPDX-License-Identifier: Apache-2.0
#include "places/kmeans.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <set>

#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;

using Vector = std::vector<double>;

/// Three blobs in the plane, made without a generator so that Python makes the same.
DescriptorMatrix blobs() {
  const double corners[3][2] = {{0, 0}, {6, 1}, {2, 7}};
  DescriptorMatrix rows(2);
  for (std::int64_t i = 0; i < 90; ++i) {
    const double u = static_cast<double>((1103515245 * i + 12345) % 65536) / 65536;
    const double v = static_cast<double>((22695477 * i + 1) % 65536) / 65536;
    rows.append(
        std::vector{static_cast<float>(corners[i % 3][0] + u), static_cast<float>(corners[i % 3][1] + v)});
  }
  return rows;
}

double squaredDistance(DescriptorView a, const Vector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

std::vector<Vector> means(const DescriptorMatrix& rows, const std::vector<int>& clusters, std::size_t k) {
  std::vector<Vector> sums(k, Vector(rows.labels()));
  Vector counts(k);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto c = static_cast<std::size_t>(clusters[i]);
    ++counts[c];
    for (std::size_t d = 0; d < rows.labels(); ++d) sums[c][d] += rows.row(i)[d];
  }
  for (std::size_t c = 0; c < k; ++c)
    for (double& value : sums[c]) value /= counts[c];
  return sums;
}

double inertia(const DescriptorMatrix& rows, const std::vector<int>& clusters, std::size_t k) {
  const auto centers = means(rows, clusters, k);
  double sum = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    sum += squaredDistance(rows.row(i), centers[static_cast<std::size_t>(clusters[i])]);
  return sum;
}

/// Lloyd's algorithm as the book has it, from rows drawn by chance; the best of many starts.
double plainKMeans(const DescriptorMatrix& rows, std::size_t k, int starts, std::mt19937& random) {
  double best = std::numeric_limits<double>::infinity();
  for (int start = 0; start < starts; ++start) {
    std::vector<Vector> centers;
    for (std::size_t c = 0; c < k; ++c) {
      const auto row = rows.row(random() % rows.size());
      centers.emplace_back(row.begin(), row.end());
    }
    double before = std::numeric_limits<double>::infinity(), now = before;
    do {
      before = now;
      now = 0;
      std::vector<Vector> sums(k, Vector(rows.labels()));
      Vector counts(k);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        std::size_t nearest = 0;
        for (std::size_t c = 1; c < k; ++c)
          if (squaredDistance(rows.row(i), centers[c]) < squaredDistance(rows.row(i), centers[nearest]))
            nearest = c;
        now += squaredDistance(rows.row(i), centers[nearest]);
        ++counts[nearest];
        for (std::size_t d = 0; d < rows.labels(); ++d) sums[nearest][d] += rows.row(i)[d];
      }
      for (std::size_t c = 0; c < k; ++c)
        for (std::size_t d = 0; d < rows.labels() && counts[c] > 0; ++d)
          centers[c][d] = sums[c][d] / counts[c];
    } while (now < before);
    best = std::min(best, now);
  }
  return best;
}

DescriptorMatrix noise(std::size_t count, std::size_t labels, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  DescriptorMatrix rows(labels);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<float> row(labels);
    for (float& v : row) v = normal(random) + static_cast<float>(i % 5);
    rows.append(row);
  }
  return rows;
}

TEST(KMeans, IsAsTightAsScikitLearn) {
  // scikit-learn 1.2.1, KMeans(k, n_init=50, random_state=0).fit(X).inertia_
  const DescriptorMatrix rows = blobs();
  for (const auto& [k, tightest] : {std::pair<std::size_t, double>{1, 1410.7833251953125},
                                    {2, 563.2150268554688},
                                    {3, 14.839900970458984},
                                    {6, 6.707291603088379}})
    EXPECT_NEAR(inertia(rows, kMeans(rows, k, {50, 1}), k), tightest, 1e-4 * tightest) << k;
}

TEST(KMeans, IsAsTightAsThePlainAlgorithmInManyDimensions) {
  std::mt19937 random(5);
  for (const std::size_t k : {2U, 5U, 9U}) {
    const DescriptorMatrix rows = noise(120, 40, static_cast<unsigned>(k));
    const double plain = plainKMeans(rows, k, 30, random);
    EXPECT_LE(inertia(rows, kMeans(rows, k, {30, 1}), k), 1.01 * plain) << k;
  }
}

TEST(KMeans, EveryRowIsInTheClusterWhoseMeanIsNearest) {
  const DescriptorMatrix rows = noise(150, 12, 8);
  const auto clusters = kMeans(rows, 7);
  const auto centers = means(rows, clusters, 7);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double own = squaredDistance(rows.row(i), centers[static_cast<std::size_t>(clusters[i])]);
    for (const Vector& other : centers) EXPECT_LE(own, squaredDistance(rows.row(i), other) + 1e-4) << i;
  }
}

TEST(KMeans, LeavesNoClusterEmptyEvenWhenRowsAreEqual) {
  DescriptorMatrix rows(3);
  for (int i = 0; i < 12; ++i) rows.append(std::vector<float>{0.5F, 0.25F, static_cast<float>(i / 6)});
  for (const std::size_t k : {1U, 2U, 5U, 12U}) {
    const auto clusters = kMeans(rows, k);
    EXPECT_EQ(std::set<int>(clusters.begin(), clusters.end()).size(), k);
  }
}

TEST(KMeans, TheSeedAloneDecides) {
  const DescriptorMatrix rows = noise(200, 30, 2);
  const auto first = kMeans(rows, 12, {1, 4});
  cv::theRNG().next();
  const std::uint64_t state = cv::theRNG().state;
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  EXPECT_EQ(kMeans(rows, 12, {1, 4}), first);
  cv::setNumThreads(threads);
  EXPECT_EQ(cv::theRNG().state, state) << "the caller's random numbers have changed";
  EXPECT_NE(kMeans(rows, 12, {1, 5}), first);
}

TEST(KMeans, RefusesWhatCannotBe) {
  const DescriptorMatrix rows = blobs();
  EXPECT_THAT([&] { kMeans(rows, 0); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { kMeans(rows, 91); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { kMeans(DescriptorMatrix(3), 1); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { kMeans(rows, 2, {0, 1}); }, FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia::experiments
