// Which instances are accepted: false alarms of a scene, places of their own, and each point explained once.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/joint_verification.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/recognition/false_alarms.hpp"
#include "estancia/recognition/pose_candidates.hpp"

namespace estancia {
namespace {

TEST(FalseAlarmModel, TheSameEvidenceIsWorthLessWhereWrongPosesReachMore) {
  const FalseAlarmModel quiet(std::vector<double>(8, 0.14)), loud(std::vector<double>(8, 0.22));
  EXPECT_NEAR(loud.chance(), 0.22, 1e-12);
  EXPECT_LT(quiet.rate(0.3), loud.rate(0.3) / 10);
  EXPECT_EQ(quiet.rate(0), 1);
  EXPECT_GT(loud.evidenceOf(0.01), quiet.evidenceOf(0.01) + 0.07);
  for (const double rate : {0.5, 0.01, 1e-6}) EXPECT_NEAR(loud.rate(loud.evidenceOf(rate)) / rate, 1, 1e-9);
  EXPECT_NEAR(loud.rate(0.5) / loud.rate(0.5 + loud.evidenceScale()), std::exp(1), 1e-9);
}

TEST(FalseAlarmModel, FewWrongPosesAreFilledUp) {
  const double usual = FalseAlarmModel().chance();
  EXPECT_GT(usual, 0);
  EXPECT_EQ(FalseAlarmModel({0.01, 0.02}).chance(), usual) << "less than usual is not believed";
  EXPECT_NEAR(FalseAlarmModel({0.3}).chance(), (0.3 + 7 * usual) / 8, 1e-12);
  EXPECT_NEAR(FalseAlarmModel({0.01, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3}).chance(), 0.3, 1e-12)
      << "the best eight count";
}

PoseHypothesis at(double x, double evidence) {
  PoseHypothesis h;
  h.pose = cv::Affine3d(cv::Vec3d(), cv::Vec3d(x, 0, 1));
  h.evidence = evidence;
  return h;
}

std::vector<PoseHypothesis> withWrongPoses(std::vector<PoseHypothesis> poses) {
  for (int i = 0; i < 12; ++i) poses.push_back(at(10 + i, 0.15 - 0.002 * i));
  return poses;
}

TEST(Instances, SeveralOfOneModelDoNotHideEachOther) {
  for (std::size_t count : {1U, 2U, 5U, 9U}) {
    std::vector<PoseHypothesis> poses;
    for (std::size_t i = 0; i < count; ++i) {
      poses.push_back(at(static_cast<double>(i), 0.6 - 0.02 * static_cast<double>(i)));
      poses.push_back(
          at(static_cast<double>(i) + 0.01, 0.599 - 0.02 * static_cast<double>(i)));  // slightly off
    }
    const Instances found = instancesOf(withWrongPoses(poses), {0, 0, 0}, 0.1, 0.01);
    EXPECT_EQ(found.poses.size(), count);
    EXPECT_NEAR(found.falseAlarms.chance(), 0.143, 0.001) << "of poses elsewhere alone";
  }
}

TEST(Instances, ChanceIsNone) {
  const Instances found = instancesOf(withWrongPoses({at(0, 0.17)}), {0, 0, 0}, 0.1, 0.01);
  EXPECT_TRUE(found.poses.empty());
  EXPECT_GT(found.falseAlarms.rate(0.17), 0.01);
  EXPECT_TRUE(instancesOf({}, {0, 0, 0}, 0.1, 0.01).poses.empty());
}

/// The best value over all subsets.
double bestByTrying(const std::vector<double>& gains, const std::vector<double>& losses) {
  double best = 0;
  for (std::size_t set = 0; set < (std::size_t{1} << gains.size()); ++set) {
    double value = 0;
    for (std::size_t i = 0; i < gains.size(); ++i) {
      if ((set >> i & 1U) == 0) continue;
      value += gains[i];
      for (std::size_t j = 0; j < i; ++j)
        if ((set >> j & 1U) != 0) value -= losses[i * gains.size() + j];
    }
    best = std::max(best, value);
  }
  return best;
}

TEST(BestSubset, IsExact) {
  std::mt19937 random(5);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t count = 1 + random() % 10;
    std::vector<double> gains(count), losses(count * count, 0);
    for (double& gain : gains) gain = uniform() - 0.2;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (uniform() < 0.4) losses[i * count + j] = losses[j * count + i] = uniform();
    double value = 0;
    const auto chosen = bestSubset(gains, losses);
    for (const std::size_t i : chosen) {
      value += gains[i];
      for (const std::size_t j : chosen)
        if (j < i) value -= losses[i * count + j];
    }
    EXPECT_NEAR(value, bestByTrying(gains, losses), 1e-12);
  }
  EXPECT_TRUE(bestSubset({}, {}).empty());
}

TEST(BestSubset, TwoThatFitBeatOneThatCoversBoth) {
  // The second overlaps both others.
  EXPECT_THAT(bestSubset({4, 5, 3}, {0, 4, 0, 4, 0, 3, 0, 3, 0}), testing::ElementsAre(0, 2));
}

TEST(BestSubset, ManyThatAllOverlapAreChosenGreedily) {
  std::vector<double> gains(40), losses(1600, 2);
  for (std::size_t i = 0; i < gains.size(); ++i) gains[i] = 1 + 0.01 * static_cast<double>(i);
  EXPECT_THAT(bestSubset(gains, losses), testing::ElementsAre(39));
}

}  // namespace
}  // namespace estancia
