// Which poses count and which instances are accepted: votes, false alarms, each point explained once.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/pose_candidates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/scales.hpp"

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
  for (int trial = 0; trial < 60; ++trial) {
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

TEST(BestSubset, ManyThatAllOverlapAreChosenGreedily) {
  std::vector<double> gains(40), losses(1600, 2);
  for (std::size_t i = 0; i < gains.size(); ++i) gains[i] = 1 + 0.01 * static_cast<double>(i);
  EXPECT_THAT(bestSubset(gains, losses), testing::ElementsAre(39));
}

/// A wall of a meter before the sensor, and a square of it that is tried as a model.
struct Wall {
  Surface surface;
  NearestField field;
  RangeImage view;
  OrientedPoints model;

  static PointCloud square(float half, float z, float step) {
    PointCloud cloud;
    for (float x = -half; x <= half; x += step)
      for (float y = -half; y <= half; y += step) {
        cloud.points.emplace_back(x, y, z);
        cloud.normals.emplace_back(0.F, 0.F, -1.F);
      }
    cloud.width = cloud.points.size();
    cloud.height = 1;
    return cloud;
  }
  Wall()
      : surface("wall", square(0.5F, 2, 0.005F)),
        field(surface.points(), 0.01, 0.05, 1),
        view(surface.points(), 0.01) {
    const PointCloud part = square(0.1F, 2, 0.01F);
    model.points = part.points;
    model.normals = part.normals;
  }
  PoseScore at(const cv::Affine3d& pose) const {
    return scorePose(model, {surface, field, view}, pose, {0.01, 0.03, 0.7});
  }
};

TEST(PoseScore, VotesForWhatIsThereAndAgainstWhatIsSeenThrough) {
  const Wall wall;
  ASSERT_TRUE(wall.view.known());
  const PoseScore on = wall.at(cv::Affine3d::Identity());
  EXPECT_NEAR(on.vote(), 1, 0.01);
  EXPECT_EQ(on.points, wall.model.points.size());
  // Half the offset that is allowed: 1 − (1/2)².
  EXPECT_NEAR(wall.at(cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 0.005))).vote(), 0.75, 0.01);
  const PoseScore before = wall.at(cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, -0.3)));
  EXPECT_NEAR(before.seenThrough, 1, 0.01);
  EXPECT_NEAR(before.vote(), -1, 0.01);
  const PoseScore behind = wall.at(cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 0.3)));
  EXPECT_NEAR(behind.occluded, 1, 0.01);
  EXPECT_NEAR(behind.vote(), 0, 0.01);
  const PoseScore nearby = wall.at(cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 0.02)));
  EXPECT_NEAR(nearby.mismatched, 1, 0.01);
  EXPECT_NEAR(nearby.vote(), -0.25, 0.01);
  const PoseScore aside = wall.at(cv::Affine3d(cv::Vec3d(), cv::Vec3d(3, 0, 0)));
  EXPECT_NEAR(aside.vote(), 0, 0.01);  // not observed there
}

TEST(RecognitionScales, FollowSpacingNoiseAndModel) {
  const RecognitionOptions options = RecognitionOptions::preset("default");
  const RecognitionScales clean = scalesFor(options, 0.0018, 0.002, 0.0005, 0.3);
  EXPECT_NEAR(clean.unit, 0.002, 1e-5);
  EXPECT_NEAR(clean.tolerance, 0.005, 1e-4);
  const RecognitionScales noisy = scalesFor(options, 0.0018, 0.002, 0.01, 0.3);
  EXPECT_NEAR(noisy.normalRadius, 0.03, 1e-3);
  EXPECT_EQ(noisy.tolerance, clean.tolerance);  // averaged surfaces do not get worse
  EXPECT_EQ(noisy.descriptorRadius, clean.descriptorRadius);
  const RecognitionScales millimeters = scalesFor(options, 1.8, 2, 0.5, 300);
  EXPECT_NEAR(millimeters.normalRadius, 1000 * clean.normalRadius, 1e-6);
  const RecognitionScales large = scalesFor(options, 0.0018, 0.002, 0.0005, 4);
  EXPECT_NEAR(large.unit, 0.01, 1e-4);  // a 400th
  RecognitionOptions own = options;
  own.tolerance = 0.02;
  EXPECT_EQ(scalesFor(own, 0.0018, 0.002, 0.0005, 0.3).tolerance, 0.02);
}

}  // namespace
}  // namespace estancia
