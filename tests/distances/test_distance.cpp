// SPDX-License-Identifier: Apache-2.0
#include "estancia/distances/distance.hpp"
#include "estancia/stats/label_scale.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/errors.hpp"

namespace estancia {
namespace {

using Values = std::vector<float>;
using test::FailsWith;

// scipy 1.10: p = [.5, .2, .2, .1], q = [.1, .3, .3, .3]
const Values p{0.5F, 0.2F, 0.2F, 0.1F}, q{0.1F, 0.3F, 0.3F, 0.3F};

Values embedded(Embedding embedding, const Values& v) {
  Values out(v.size());
  embed(embedding, v, out);
  return out;
}

TEST(Distance, FollowsTheFormulasInDoublePrecision) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform;
  Values a(1001), b(1001), w(1001);
  for (auto* v : {&a, &b, &w})
    for (float& x : *v) x = uniform(random);
  double most = 0, mostWeighted = 0, jeffreys = 0, jensenShannon = 0;
  double sumW = 0, squares = 0, plainSquares = 0, absolute = 0, chi = 0, ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = b[i], d = x - y, mean = (x + y) / 2;
    most = std::max(most, std::fabs(x - y));
    mostWeighted = std::max(mostWeighted, w[i] * std::fabs(x - y));
    jeffreys += (x - y) * std::log((x + clrFloor) / (y + clrFloor));
    jensenShannon += (x > 0 ? x * std::log(x / mean) : 0) + (y > 0 ? y * std::log(y / mean) : 0);
    sumW += w[i];
    squares += w[i] * d * d;
    plainSquares += d * d;
    absolute += std::fabs(d);
    chi += d * d / (x + y);
    ab += x * y;
    aa += x * x;
    bb += y * y;
  }
  const double n = 1001;
  EXPECT_NEAR(compare(Comparison::meanSquare, a, b, w), squares / sumW, 1e-6);  // Eq. 4.5
  EXPECT_NEAR(compare(Comparison::rootMeanSquare, a, b, w), std::sqrt(squares / sumW), 1e-6);
  EXPECT_NEAR(compare(Comparison::euclidean, a, b, w), std::sqrt(n * squares / sumW), 1e-4);
  EXPECT_NEAR(compare(Comparison::euclidean, a, b), std::sqrt(plainSquares), 1e-4);
  EXPECT_NEAR(compare(Comparison::l1, a, b), absolute, 1e-3);
  EXPECT_NEAR(compare(Comparison::chiSquared, a, b), chi / 2, 1e-3);
  EXPECT_NEAR(compare(Comparison::cosine, a, b), 1 - ab / std::sqrt(aa * bb), 1e-6);
  EXPECT_NEAR(compare(Comparison::chebyshev, a, b), most, 1e-6);  // Eq. 5.1
  EXPECT_NEAR(compare(Comparison::chebyshev, a, b, w), mostWeighted * n / sumW, 1e-5);
  EXPECT_NEAR(compare(Comparison::kullbackLeibler, a, b), jeffreys, 1e-6 * jeffreys);
  EXPECT_NEAR(compare(Comparison::jensenShannon, a, b), std::sqrt(jensenShannon / 2), 1e-5);
  EXPECT_NEAR(compare(Comparison::bhattacharyya, a, b), -std::log(ab / std::sqrt(aa * bb)), 1e-6);
}

TEST(Distance, EveryNamedOneIsZeroOnlyForTheSameAndSymmetric) {
  for (const Distance& distance : baseDistances()) {
    const Values a = embedded(distance.embedding, p), b = embedded(distance.embedding, q);
    EXPECT_NEAR(compare(distance.comparison, a, a), 0, 1e-6) << distance.name;
    EXPECT_GT(compare(distance.comparison, a, b), 1e-4) << distance.name;
    EXPECT_DOUBLE_EQ(compare(distance.comparison, a, b), compare(distance.comparison, b, a)) << distance.name;
  }
}

TEST(Distance, HellingerIsEuclideanOnSquareRootsAndLogRatiosAreCentered) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += std::pow(std::sqrt(p[i]) - std::sqrt(q[i]), 2);
  EXPECT_NEAR(
      compare(Comparison::euclidean, embedded(Embedding::squareRoot, p), embedded(Embedding::squareRoot, q)),
      std::sqrt(sum), 1e-6);
  const Values a = embedded(Embedding::centeredLogRatio, p);
  double logs = 0;
  for (const float v : p) logs += std::log(v) / 4;
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], std::log(p[i]) - logs, 1e-3);
  for (const float v : embedded(Embedding::centeredLogRatio, {1, 0, 0, 0})) EXPECT_TRUE(std::isfinite(v));
}

TEST(Distance, MissingLabelsHaveHalfOfTheLeastProbability) {
  EXPECT_FLOAT_EQ(missingProbability(Values{0.6F, 0, 0.2F, 0}), 0.1F);
  EXPECT_EQ(missingProbability(p), 0);
  EXPECT_EQ(missingProbability(Values{0, 0, 0}), 0);
  EXPECT_EQ(embedded(Embedding::centeredLogRatio, {0.6F, 0, 0.2F, 0}),
            embedded(Embedding::centeredLogRatio, {0.6F, 0.1F, 0.2F, 0.1F}));
  Values parts(4);
  embed(Embedding::centeredLogRatio, Values{0.5F, 0, 0.8F, 0}, parts, std::vector<LabelPart>{{2, 1}, {2, 1}});
  for (const std::size_t first : {0U, 2U}) EXPECT_NEAR(parts[first], std::log(2) / 2, 1e-5);
}

TEST(Distance, DivergencesOfDistributionsThatShareNothingAreFinite) {
  const Values a{1, 0, 0}, b{0, 1, 0}, none{0, 0, 0};
  EXPECT_NEAR(compare(Comparison::jensenShannon, a, b), std::sqrt(std::log(2.0)), 1e-6);  // the largest
  EXPECT_NEAR(compare(Comparison::kullbackLeibler, a, b), 2 * std::log(1 / 1e-7), 1e-4);
  EXPECT_NEAR(compare(Comparison::jensenShannon, a, none), std::sqrt(std::log(2.0) / 2), 1e-6);
  EXPECT_DOUBLE_EQ(compare(Comparison::jensenShannon, none, none), 0);
  EXPECT_DOUBLE_EQ(compare(Comparison::kullbackLeibler, none, none), 0);
}

TEST(Distance, CentersAndSumsUpInEachPart) {
  const std::vector<LabelPart> parts{{2, 1}, {3, 2}};
  const Values both{0.75F, 0.25F, 0.5F, 0.25F, 0.25F};
  Values out(5);
  embed(Embedding::cumulative, both, out, parts);
  EXPECT_EQ(out, (Values{0.75F, 1, 0.5F, 0.75F, 1}));
  embed(Embedding::centered, both, out, parts);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(out[i], both[i] - (i < 2 ? 0.5F : 1.0F / 3));
}

TEST(Distance, NamesHaveSigmaFormsAndUnknownOnesAreRefused) {
  EXPECT_TRUE(getDistance("hellinger-sigma").sigmaWeighted);
  EXPECT_EQ(getDistance("hellinger-sigma").name, "hellinger-sigma");
  EXPECT_FALSE(getDistance("hellinger").sigmaWeighted);
  for (const char* name : {"manhattan", "weighted-sigma", "-sigma", ""})
    EXPECT_THAT([&] { getDistance(name); }, FailsWith(ErrorCode::unknownName));
  for (const Choice& known : distances()) EXPECT_EQ(getDistance(known.name).name, known.name);
}

TEST(Distance, RefusesDifferentLengths) {
  const Values three(3, 0.1F);
  EXPECT_THAT([&] { compare(Comparison::l1, p, three); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { compare(Comparison::l1, p, q, three); }, FailsWith(ErrorCode::mismatch));
}

const std::vector<float> first{0.7F, 0.3F, 0.2F, 0.5F, 0.3F}, second{0.4F, 0.6F, 0.1F, 0.1F, 0.8F};

DescriptorMatrix both() {
  DescriptorMatrix rows(5);
  rows.append(first);
  rows.append(second);
  return rows;
}

double distanceOf(const Distance& distance) {
  const DescriptorMatrix vectors = comparedVectors(both(), both(), distance);
  return compare(distance.comparison, vectors.row(0), vectors.row(1));
}

/// Two models of weights 1 and 3.
TEST(ComparedVectors, WeighThePartsOfAConjunction) {
  const std::vector<LabelPart> parts{{2, 1}, {3, 3}};
  struct Part {
    std::vector<float> a, b;
    double weight;
  };
  const std::vector<Part> alone{
      {{first.begin(), first.begin() + 2}, {second.begin(), second.begin() + 2}, 0.25},
      {{first.begin() + 2, first.end()}, {second.begin() + 2, second.end()}, 0.75}};
  const auto sum = [&](const char* name, auto term) {
    const Distance distance = getDistance(name);
    double total = 0;
    for (Part part : alone) {
      embed(distance.embedding, part.a, part.a);
      embed(distance.embedding, part.b, part.b);
      total += part.weight * term(compare(distance.comparison, part.a, part.b));
    }
    return total;
  };
  const auto itself = [](double d) { return d; };
  const auto square = [](double d) { return d * d; };
  for (const char* name : {"clr-cosine", "pearson", "cosine"})  // the weighted mean of the parts' own
    EXPECT_NEAR(distanceOf(getDistance(name, parts)), sum(name, itself), 1e-6) << name;
  for (const char* name : {"kullback-leibler", "chi2"})
    EXPECT_NEAR(distanceOf(getDistance(name, parts)), 2 * sum(name, itself), 1e-5) << name;
  for (const char* name : {"jensen-shannon", "l2", "hellinger"})
    EXPECT_NEAR(std::pow(distanceOf(getDistance(name, parts)), 2), 2 * sum(name, square), 1e-5) << name;
  // The largest difference of any label of any part, as the weight acts on its square.
  EXPECT_NEAR(distanceOf(getDistance("ks", parts)), std::sqrt(2 * 0.75) * 0.5, 1e-6);
  EXPECT_NEAR(distanceOf(getDistance("cumulative-ks", parts)), std::sqrt(2 * 0.75) * 0.5, 1e-6);
}

}  // namespace
}  // namespace estancia
