// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/compared_vectors.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace estancia {
namespace {

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

TEST(ComparedVectors, AreUnitVectorsWhereTheComparisonIsACosine) {
  for (const char* name : {"clr-cosine", "standardized-clr", "pearson", "cosine"}) {
    const DescriptorMatrix vectors = comparedVectors(both(), both(), getDistance(name));
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(dot(vectors.row(i), vectors.row(i)), 1, 1e-6) << name;
  }
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
