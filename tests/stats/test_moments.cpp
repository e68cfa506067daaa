// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/moments.hpp"
#include "support/errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace estancia {
namespace {

using test::FailsWith;

using Values = std::vector<float>;

std::vector<Values> randomVectors(std::size_t count, std::size_t labels, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform;
  std::vector<Values> all(count, Values(labels));
  for (auto& v : all)
    for (float& x : v) x = uniform(random);
  return all;
}

/// Two passes in double precision.
void expectMoments(const Moments& moments, const std::vector<Values>& all, const std::vector<double>& weights,
                   double tolerance) {
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    double total = 0, mean = 0, variance = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
      total += weights[n];
      mean += weights[n] * all[n][i];
    }
    mean /= total;
    for (std::size_t n = 0; n < all.size(); ++n) variance += weights[n] * std::pow(all[n][i] - mean, 2);
    EXPECT_NEAR(moments.mean()[i], mean, tolerance);
    EXPECT_NEAR(moments.variance()[i], variance / total, tolerance);
  }
}

TEST(Moments, WeightsCount) {
  const auto all = randomVectors(20, 5);
  std::vector<double> weights;
  Moments moments(5, true);
  for (std::size_t i = 0; i < all.size(); ++i) {
    weights.push_back(0.1 + 0.05 * static_cast<double>(i));
    moments.add(all[i], weights.back());
  }
  expectMoments(moments, all, weights, 1e-6);
}

TEST(Moments, WeightCanBeTakenBack) {
  const auto all = randomVectors(12, 5);
  std::vector<double> weights(12, 1.0);
  Moments moments(5, true);
  for (const auto& v : all) moments.add(v);
  for (std::size_t i = 9; i < 12; ++i) {
    moments.add(all[i], -0.5);
    weights[i] = 0.5;
  }
  expectMoments(moments, all, weights, 1e-5);
  EXPECT_THAT([&] { moments.add(all[0], -100); }, FailsWith(ErrorCode::invalidState));
}

TEST(Moments, MergedAreThoseOfAllImages) {
  const auto all = randomVectors(30, 5);
  Moments left(5, true), right(5, true);
  for (std::size_t i = 0; i < all.size(); ++i) (i < 11 ? left : right).add(all[i]);
  left.merge(right);
  expectMoments(left, all, std::vector<double>(30, 1.0), 1e-6);
  left.merge(Moments(5, true));  // nothing
  EXPECT_DOUBLE_EQ(left.weight(), 30);
}

TEST(Moments, StayTrueOverAMillionImages) {
  // A place that slowly changes by a hundredth: plain float32 Welford stops moving long before the end.
  constexpr std::size_t images = 1'000'000;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1e-3F, 1e-3F);
  Moments moments(1, true);
  double sum = 0, squares = 0;
  for (std::size_t n = 0; n < images; ++n) {
    const Values v{0.5F + 0.01F * static_cast<float>(n) / images + uniform(random)};
    moments.add(v);
    sum += v[0] - 0.5;
    squares += (v[0] - 0.5) * (v[0] - 0.5);
  }
  const double mean = sum / images;
  EXPECT_NEAR(moments.mean()[0], 0.5 + mean, 1e-7);
  EXPECT_NEAR(std::sqrt(moments.variance()[0]), std::sqrt(squares / images - mean * mean), 1e-5);
}

TEST(Moments, ComeBackFromBytes) {
  const auto all = randomVectors(7, 5);
  for (const bool spread : {true, false}) {
    Moments moments(5, spread);
    for (const auto& v : all) moments.add(v);
    Moments back = Moments::fromBytes(moments.toBytes(), 5, spread);
    back.add(all[0]);
    moments.add(all[0]);
    EXPECT_EQ(moments.toBytes(), back.toBytes());
  }
}

}  // namespace
}  // namespace estancia
