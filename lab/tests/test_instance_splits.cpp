// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "estancia/core/error.hpp"
#include "objects/instance_splits.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::errorOf;
using test::FailsWith;
using testing::ElementsAre;

/// Each instance of a word is on one side, and each word that can be is tested by one.
void expectSound(const InstanceSplit& split, const std::vector<int>& wordOf) {
  std::set<std::size_t> seen(split.train.begin(), split.train.end());
  for (const std::size_t i : split.test) EXPECT_TRUE(seen.insert(i).second) << i << " is on both sides";
  EXPECT_EQ(seen.size(),
            static_cast<std::size_t>(std::ranges::count_if(wordOf, [](int w) { return w >= 0; })));
  EXPECT_TRUE(std::ranges::is_sorted(split.train));
  EXPECT_TRUE(std::ranges::is_sorted(split.test));
  std::multiset<int> tested;
  for (const std::size_t i : split.test) tested.insert(wordOf[i]);
  for (const int word : std::set<int>(wordOf.begin(), wordOf.end()))
    EXPECT_EQ(tested.count(word), word >= 0 && std::ranges::count(wordOf, word) > 1 ? 1U : 0U) << word;
}

TEST(Splits, BaselineTestsWhatIsNamedWorst) {
  const std::vector<int> wordOf{0, 1, 0, 1, 0, 2, -1};
  const std::vector<double> labeled{0.9, 0.2, 0.1, 0.8, 0.5, 0.0, 0.0};
  const InstanceSplit split = baselineSplit(wordOf, labeled);
  expectSound(split, wordOf);
  EXPECT_EQ(split.name, "baseline");
  EXPECT_THAT(split.test, ElementsAre(1, 2));
  EXPECT_THAT(split.train, ElementsAre(0, 3, 4, 5));
}

TEST(Splits, RandomOnesDifferAndAreReproducible) {
  const std::vector<int> wordOf{0, 0, 0, 1, 1, 1, 2, 2, 2, 3, -1};
  const auto splits = randomSplits(wordOf, 20, 5);
  ASSERT_EQ(splits.size(), 20U);
  std::set<std::vector<std::size_t>> tested;
  for (const InstanceSplit& split : splits) {
    expectSound(split, wordOf);
    tested.insert(split.test);
  }
  EXPECT_EQ(tested.size(), 20U);
  EXPECT_EQ(splits[0].name, "random 01");
  EXPECT_EQ(splits[19].name, "random 20");
  const auto again = randomSplits(wordOf, 20, 5), other = randomSplits(wordOf, 20, 6);
  bool differ = false;
  for (std::size_t i = 0; i < splits.size(); ++i) {
    EXPECT_EQ(splits[i].test, again[i].test);
    differ = differ || splits[i].test != other[i].test;
  }
  EXPECT_TRUE(differ);
}

TEST(Splits, ThereAreNoMoreThanThereAre) {
  const std::vector<int> wordOf{0, 0, 1, 1, 1};
  std::set<std::vector<std::size_t>> tested;
  for (const InstanceSplit& split : randomSplits(wordOf, 30, 1)) tested.insert(split.test);
  EXPECT_EQ(tested.size(), 6U);
  EXPECT_EQ(randomSplits(wordOf, 6, 1).size(), 6U);
  EXPECT_EQ(randomSplits(wordOf, 0, 1).size(), 0U);
  std::vector<int> many(180);  // 3⁶⁰ splits are more than can be counted
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<int>(i / 3);
  EXPECT_EQ(randomSplits(many, 30, 1).size(), 30U);
}

TEST(Splits, NothingToTestIsAnError) {
  const std::vector<int> single{0, 1, 2, -1, -1}, none;
  const std::vector<double> labeled(5, 0.5), few(2);
  EXPECT_THAT([&] { baselineSplit(single, labeled); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { randomSplits(single, 3, 1); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_NE(errorOf([&] { randomSplits(none, 3, 1); }), "");
  EXPECT_THAT([&] { baselineSplit(single, few); }, FailsWith(ErrorCode::invalidInput, "5", "2"));
}

}  // namespace
}  // namespace estancia::experiments
