// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/method_comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::Pair;

/// `steps[m]` apart on average, so that method 0 is the best where they fall.
MethodScores sample(std::uint64_t seed, std::size_t tests, const std::vector<double>& means, double noise) {
  test::Random random(seed);
  MethodScores scores;
  for (std::size_t m = 0; m < means.size(); ++m) scores.methods.push_back(std::string(1, 'a' + char(m)));
  for (std::size_t t = 0; t < tests; ++t) {
    scores.tests.push_back("test " + std::to_string(t));
    scores.values.emplace_back();
    for (const double mean : means) scores.values.back().push_back(mean + noise * random.uniform());
  }
  return scores;
}

TEST(MethodComparison, RanksTestsAndCountsAgainstTheBest) {
  // c is best, then a, then b, in every test; d equals a everywhere.
  MethodScores scores{{"a", "b", "c", "d"}, {}, {}};
  for (int t = 0; t < 20; ++t) {
    scores.tests.push_back(std::to_string(t));
    scores.values.push_back({0.8, 0.5, t == 0 ? 0.8 : 0.9, 0.8});
  }
  const MethodComparison found = compareMethods(scores);
  EXPECT_EQ(found.control, 2U);
  EXPECT_TRUE(found.differ);
  std::vector<std::size_t> order;
  for (const auto& row : found.rows) order.push_back(row.method);
  EXPECT_THAT(order, ElementsAre(2, 0, 3, 1)) << "a before d: equal ranks stay in order";
  EXPECT_FALSE(found.rows[0].p);
  EXPECT_FALSE(found.rows[0].rejected);
  EXPECT_EQ(found.rows[1].control, (WinRecord{19, 1, 0}));
  EXPECT_EQ(found.rows[3].control, (WinRecord{20, 0, 0}));
  EXPECT_TRUE(found.rows[3].rejected);
  EXPECT_DOUBLE_EQ(found.rows[3].meanRank, 4);
  EXPECT_EQ(found.pairs.size(), 3U);
  EXPECT_FALSE(found.criticalDifference);
  EXPECT_FALSE(found.wilcoxon);

  ComparisonOptions smaller;
  smaller.better = Better::smaller;
  const MethodComparison turned = compareMethods(scores, smaller);
  EXPECT_EQ(turned.control, 1U) << "the smallest is the best now";
  EXPECT_DOUBLE_EQ(turned.rows[0].meanRank, 1);
}

TEST(MethodComparison, GroupsWhatIsNotFoundToDiffer) {
  const MethodScores scores = sample(3, 30, {4, 3.9, 2, 1.95, 0}, 1.5);
  ComparisonOptions options;
  for (const PostHoc postHoc : {PostHoc::shaffer, PostHoc::nemenyi}) {
    options.postHoc = postHoc;
    const MethodComparison found = compareMethods(scores, options);
    EXPECT_EQ(found.pairs.size(), 10U);
    EXPECT_EQ(found.criticalDifference.has_value(), postHoc == PostHoc::nemenyi);
    EXPECT_THAT(found.groups, ElementsAre(Pair(0, 1), Pair(2, 3)));
    EXPECT_FALSE(found.rows[1].rejected);
    EXPECT_TRUE(found.rows[2].rejected);
  }
  options.postHoc = PostHoc::holm;
  EXPECT_THAT(compareMethods(scores, options).groups, ElementsAre(Pair(0, 1)));
  options.control = "d";
  const MethodComparison against = compareMethods(scores, options);
  EXPECT_EQ(against.control, 3U);
  EXPECT_THAT(against.groups, ElementsAre(Pair(2, 3)));
  EXPECT_EQ(against.rows[4].control, (WinRecord{30, 0, 0})) << "d against e";
  options.control = "e";
  EXPECT_TRUE(compareMethods(scores, options).groups.empty()) << "differs from all";
}

TEST(MethodComparison, OfLittleSaysLittle) {
  const MethodComparison one = compareMethods({{"a"}, {"t"}, {{1}}});
  EXPECT_EQ(one.rows.size(), 1U);
  EXPECT_TRUE(one.groups.empty() && one.pairs.empty() && !one.differ);
  ComparisonOptions options;
  for (const Choice& named : postHocs()) {
    options.postHoc = getPostHoc(named.name);
    const MethodComparison equal = compareMethods({{"a", "b"}, {"t", "u"}, {{1, 1}, {2, 2}}}, options);
    EXPECT_FALSE(equal.differ);
    EXPECT_THAT(equal.groups, ElementsAre(Pair(0, 1)));
    EXPECT_EQ(equal.rows[1].control, (WinRecord{0, 2, 0}));
    EXPECT_EQ(equal.wilcoxon->p, 1);
  }
}

TEST(MethodComparison, SaysWhatIsWrongAndWhere) {
  const MethodScores sound{{"a", "b"}, {"t", "u"}, {{1, 2}, {3, 4}}};
  const auto refused = [](MethodScores scores, ComparisonOptions options = {}) {
    return [scores, options] { compareMethods(scores, options); };
  };
  for (const double value : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    MethodScores bad = sound;
    bad.values[1][0] = value;
    EXPECT_THAT(refused(bad), FailsWith(ErrorCode::invalidInput));
  }
  MethodScores bad = sound;
  bad.values[1].pop_back();
  EXPECT_THAT(refused(bad), FailsWith(ErrorCode::mismatch));
  bad = sound;
  bad.values.pop_back();
  EXPECT_THAT(refused(bad), FailsWith(ErrorCode::mismatch));
  bad = sound;
  bad.methods[1] = "a";
  EXPECT_THAT(refused(bad), FailsWith(ErrorCode::invalidInput));
  bad = sound;
  bad.tests[1] = "t";
  EXPECT_THAT(refused(bad), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refused({}), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refused(sound, {.control = "c"}), FailsWith(ErrorCode::unknownName));
  for (const double alpha : {0.0, 1.0, static_cast<double>(NAN)})
    EXPECT_THAT(refused(sound, {.alpha = alpha, .control = {}}), FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
