// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/grouping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/recognition/surface.hpp"
#include "recognition/made_up_surface.hpp"
#include "recognition/pcl_reference.hpp"
#include "recognition/pose_check.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::centerOf;
using test::PoseError;
using test::poseError;

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
