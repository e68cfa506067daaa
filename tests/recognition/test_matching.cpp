// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/matching.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

DescriptorMatrix randomRows(std::size_t count, std::size_t length, std::uint32_t seed, float scale = 1) {
  std::mt19937 random(seed);
  DescriptorMatrix rows(length);
  std::vector<float> row(length);
  for (std::size_t i = 0; i < count; ++i) {
    for (float& v : row) v = scale * static_cast<float>(random() % 1000) / 1000;
    rows.append(row);
  }
  return rows;
}

/// Distances of every pair, sorted.
std::vector<std::vector<NearRow>> bruteForce(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                             std::size_t count) {
  std::vector<std::vector<NearRow>> found(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::uint32_t j = 0; j < others.size(); ++j) {
      float sum = 0;
      for (std::size_t k = 0; k < rows.labels(); ++k)
        sum += (rows.row(i)[k] - others.row(j)[k]) * (rows.row(i)[k] - others.row(j)[k]);
      found[i].push_back({j, sum});
    }
    std::stable_sort(found[i].begin(), found[i].end(),
                     [](const NearRow& a, const NearRow& b) { return a.squared < b.squared; });
    found[i].resize(std::min(count, others.size()));
  }
  return found;
}

TEST(Matching, FindsWhatBruteForceFinds) {
  for (const float scale : {1.F, 100.F}) {  // as SHOT and as FPFH
    const DescriptorMatrix rows = randomRows(301, 33, 1, scale), others = randomRows(257, 33, 2, scale);
    const auto ours = nearestRows(rows, others, 5), plain = bruteForce(rows, others, 5);
    ASSERT_EQ(ours.size(), plain.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      ASSERT_EQ(ours[i].size(), 5U);
      for (std::size_t k = 0; k < 5; ++k) {
        EXPECT_EQ(ours[i][k].other, plain[i][k].other);
        EXPECT_FLOAT_EQ(ours[i][k].squared, plain[i][k].squared);
      }
    }
  }
}

TEST(Matching, OfEqualRowsTheFirstIsNearest) {
  DescriptorMatrix others(4), rows(4);
  for (int i = 0; i < 6; ++i) others.append(std::vector<float>{1, 2, 3, 4});
  rows.append(std::vector<float>{1, 2, 3, 4});
  const auto found = nearestRows(rows, others, 3);
  for (std::uint32_t k = 0; k < 3; ++k) {
    EXPECT_EQ(found[0][k].other, k);
    EXPECT_EQ(found[0][k].squared, 0.F);
  }
}

TEST(Matching, DoesNotDependOnThreads) {
  const DescriptorMatrix rows = randomRows(400, 40, 3), others = randomRows(300, 40, 4);
  EXPECT_EQ(matchDescriptors(rows, others, MatchEach::scene, 2, 0, 1),
            matchDescriptors(rows, others, MatchEach::scene, 2, 0, 3));
}

TEST(Matching, EachSideGetsItsNearest) {
  const DescriptorMatrix model = randomRows(20, 8, 5), scene = randomRows(70, 8, 6);
  const auto byScene = matchDescriptors(model, scene, MatchEach::scene, 1);
  const auto byModel = matchDescriptors(model, scene, MatchEach::model, 3);
  EXPECT_EQ(byScene.size(), 70U);
  EXPECT_EQ(byModel.size(), 60U);
  EXPECT_TRUE(std::is_sorted(byModel.begin(), byModel.end(),
                             [](const Match& a, const Match& b) { return a.squared < b.squared; }));
  std::vector<int> times(20, 0);
  for (const Match& m : byModel) ++times[m.model];
  EXPECT_EQ(times, std::vector<int>(20, 3));
}

TEST(Matching, MatchesOfUnlikeDescriptorsAreNone) {
  DescriptorMatrix model(2), scene(2);
  model.append(std::vector<float>{10, 0});
  scene.append(std::vector<float>{8, 0});    // 2 away, a quarter of its own length
  scene.append(std::vector<float>{20, 0});   // 10 away, a half
  scene.append(std::vector<float>{0, 100});  // more than its own length
  const auto within = [&](double distance) {
    return matchDescriptors(model, scene, MatchEach::scene, 1, distance).size();
  };
  EXPECT_EQ(within(0.2), 0U);
  EXPECT_EQ(within(0.3), 1U);
  EXPECT_EQ(within(0.51), 2U);
  EXPECT_EQ(within(0), 3U);
}

TEST(Matching, FewerThanAskedForAreAllThatThereAre) {
  const DescriptorMatrix rows = randomRows(3, 5, 7), none(5);
  EXPECT_EQ(nearestRows(rows, rows, 10)[0].size(), 3U);
  EXPECT_TRUE(nearestRows(rows, none, 2)[0].empty());
  EXPECT_TRUE(matchDescriptors(none, rows, MatchEach::model, 2).empty());
  EXPECT_THROW(nearestRows(rows, randomRows(3, 6, 1), 1), Error);
}

}  // namespace
}  // namespace estancia
