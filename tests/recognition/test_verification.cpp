// Poses grouped from matches, and verified together.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/grouping.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/pose_candidates.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/scales.hpp"
#include "estancia/recognition/surface.hpp"
#include "recognition/made_up_surface.hpp"
#include "recognition/pcl_reference.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::centerOf;
using test::poseError;
using test::PoseError;

/// A model whose points stand at two places of a scene, among matches that are wrong.
struct Puzzle {
  std::vector<cv::Point3f> model, scene;
  std::vector<Match> matches;
  std::vector<cv::Affine3d> poses{{cv::Vec3d(0.5, 1, -0.3), cv::Vec3d(1, 0, 2)},
                                  {cv::Vec3d(-2, 0.2, 0.1), cv::Vec3d(-1, 0.5, 1)}};

  explicit Puzzle(std::size_t wrong, std::uint32_t seed = 1, double rough = 0.002) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.F; };
    for (int i = 0; i < 60; ++i) model.emplace_back(0.3F * uniform(), 0.2F * uniform(), 0.1F * uniform());
    const auto match = [&](std::size_t m, const cv::Point3f& p) {
      matches.push_back({static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(scene.size()), uniform()});
      scene.push_back(p);
    };
    for (const cv::Affine3d& pose : poses)
      for (std::size_t m = 0; m < model.size(); m += 2)
        match(m, cv::Affine3f(pose) * model[m] +
                     cv::Point3f(uniform(), uniform(), uniform()) * static_cast<float>(rough));
    for (std::size_t i = 0; i < wrong; ++i)
      match(random() % model.size(), {4 * uniform() - 2, 4 * uniform() - 2, 4 * uniform() - 2});
    std::sort(matches.begin(), matches.end(),
              [](const Match& a, const Match& b) { return a.squared < b.squared; });
  }

  static SurfaceFeatures featuresOf(const std::vector<cv::Point3f>& points) {
    SurfaceFeatures features;
    features.points = points;
    features.keypoints.resize(points.size());
    return features;
  }
};

TEST(Grouping, FindsBothPosesAmongWrongMatches) {
  const Puzzle puzzle(300);
  const auto found = groupMatches(Puzzle::featuresOf(puzzle.model), Puzzle::featuresOf(puzzle.scene),
                                  puzzle.matches, "geometric-consistency", 0.01, 10);
  ASSERT_GE(found.size(), 2U);
  for (const cv::Affine3d& truth : puzzle.poses) {
    const bool isFound = std::any_of(found.begin(), found.begin() + 2, [&](const Hypothesis& h) {
      const PoseError e = poseError(h.pose, truth, {0.15, 0.1, 0.05});
      return e.translation < 0.005 && e.rotation < 2 && h.matches.size() >= 25;
    });
    EXPECT_TRUE(isFound);
  }
}

TEST(Grouping, HoughFindsThePoseByLocalFrames) {
  const PointCloud cloud = test::wavySheet(80, 0.3);
  const cv::Affine3d truth(cv::Vec3d(0.4, -0.2, 0.9), cv::Vec3d(0.3, 0.1, 0.5));
  const Surface model("model", cloud), scene("scene", test::moved(cloud, truth));
  const auto keypoints = findKeypoints(model, "uniform", 0.02);
  const SurfaceFeatures a = describe(model, keypoints, "shot", 0.04),
                        b = describe(scene, keypoints, "shot", 0.04);
  const auto matches = matchDescriptors(a.descriptors, b.descriptors, MatchEach::scene, 1);
  const auto found = groupMatches(a, b, matches, "hough", 0.01, 5);
  ASSERT_FALSE(found.empty());
  const PoseError e = poseError(found[0].pose, truth, centerOf(cloud));
  EXPECT_LT(e.translation, 0.002);
  EXPECT_LT(e.rotation, 1);
  EXPECT_GT(found[0].matches.size(), a.size() * 8 / 10);
}

TEST(Grouping, RefusesWhatCannotBe) {
  const Puzzle puzzle(0);
  const SurfaceFeatures model = Puzzle::featuresOf(puzzle.model), scene = Puzzle::featuresOf(puzzle.scene);
  EXPECT_THAT([&] { groupMatches(model, scene, puzzle.matches, "ransac", 0.01, 3); },
              test::FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { groupMatches(model, scene, puzzle.matches, "hough", 0, 3); },
              test::FailsWith(ErrorCode::invalidOption));
}

TEST(AgreedTransform, LeavesOutliersAlone) {
  const Puzzle puzzle(0, 5, 0);
  std::vector<cv::Point3f> from, to;
  for (std::size_t i = 0; i < puzzle.model.size(); ++i) {
    from.push_back(puzzle.model[i]);
    to.push_back(cv::Affine3f(puzzle.poses[0]) * puzzle.model[i]);
    if (i % 3 == 0) to.back() += cv::Point3f(0.1F, 0.F, 0.2F * static_cast<float>(i % 2));
  }
  const auto [pose, inliers] = agreedTransform(from, to, 0.005);
  EXPECT_EQ(inliers.size(), 40U);
  EXPECT_LT(poseError(pose, puzzle.poses[0], {}).translation, 1e-5);
}

#ifdef ESTANCIA_HAS_PCL

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs pairsOf(const std::vector<Match>& matches) {
  Pairs pairs;
  for (const Match& m : matches) pairs.emplace_back(m.model, m.scene);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(Grouping, SetsArePcls) {
  for (const std::uint32_t seed : {1U, 2U}) {
    const Puzzle puzzle(400, seed);
    const auto ours =
        consistentSets(puzzle.model, puzzle.scene, puzzle.matches, 0.02, 4, seed);  // and threads
    const auto pcls = test::pclConsistentSets(puzzle.model, puzzle.scene, puzzle.matches, 0.02, 4);
    ASSERT_EQ(ours.size(), pcls.size());
    ASSERT_GE(ours.size(), 2U);
    for (std::size_t s = 0; s < ours.size(); ++s) {
      std::vector<Match> set;
      for (const std::uint32_t i : ours[s]) set.push_back(puzzle.matches[i]);
      // PCL returns only what its RANSAC leaves.
      EXPECT_EQ(pairsOf(test::pclRansac(puzzle.model, puzzle.scene, set, 0.02)), pairsOf(pcls[s]));
    }
  }
}

#endif

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
  for (const float scale : {1.F, 100.F}) {  // lengths of SHOT and of FPFH
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

TEST(Matching, OfEqualDescriptorsTheFirstAreTheNearest) {
  const DescriptorMatrix one = randomRows(1, 8, 5);
  DescriptorMatrix equal(8);
  for (int i = 0; i < 40; ++i) equal.append(one.row(0));
  const auto found = nearestRows(one, equal, 30);
  ASSERT_EQ(found[0].size(), 30U);
  for (std::uint32_t k = 0; k < 30; ++k) EXPECT_EQ(found[0][k].other, k);
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

TEST(Instances, RatesDoNotDependOnWhatIsAllowed) {
  const auto poses = withWrongPoses({at(0, 0.6), at(1, 0.2), at(2, 0.19)});
  const Instances strict = instancesOf(poses, {0, 0, 0}, 0.1, 0.01),
                  loose = instancesOf(poses, {0, 0, 0}, 0.1, 0.9);
  EXPECT_EQ(strict.poses.size(), 1U);
  EXPECT_GT(loose.poses.size(), 1U);
  EXPECT_EQ(strict.falseAlarms.rate(0.2), loose.falseAlarms.rate(0.2));
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
