// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/verify.hpp"

#include <gtest/gtest.h>

#include "recognition/made_up_surface.hpp"
#include "recognition/pose_check.hpp"

namespace estancia {
namespace {

using test::PoseError;
using test::poseError;

/// A wavy object in front of a wall, and its model.
struct Stage {
  PointCloud object = test::wavySheet(60, 0.25), all = withWall();
  cv::Affine3d truth{cv::Vec3d(0.3, -0.2, 0.5), cv::Vec3d(0.05, -0.1, 0.2)};
  Surface scene{"scene", all};
  Surface model{"model", test::moved(object, truth.inv())};
  OrientedPoints points = spreadPoints(model, 500);
  RangeImage view{all.points, 0.004};

  PointCloud withWall() const {
    PointCloud cloud = object;
    for (const cv::Point3f& p : test::wavySheet(150, 0.65, 2).points) {
      cloud.points.emplace_back(p.x, p.y, 1.F);
      cloud.normals.emplace_back(0.F, 0.F, -1.F);
    }
    return cloud;
  }
};

const Stage& stage() {
  static const Stage one;
  return one;
}

cv::Affine3d shifted(const cv::Affine3d& pose, const cv::Vec3d& by) {
  return pose.translate(by);
}

TEST(Refine, FindsThePoseNearby) {
  const cv::Affine3d start =
      cv::Affine3d(cv::Vec3d(0.04, -0.03, 0.02), cv::Vec3d(0.01, 0.004, -0.006)) * stage().truth;
  const cv::Affine3d found = refinePose(stage().points, stage().scene, start, 0.1, 50);
  const PoseError e = poseError(found, stage().truth, cv::Point3d(stage().points.points[0]));
  EXPECT_LT(e.translation, 0.001);
  EXPECT_LT(e.rotation, 0.5);
}

TEST(Refine, LeavesAPoseWithoutPartnersAlone) {
  const cv::Affine3d far = shifted(stage().truth, {0, 0, 5});
  EXPECT_EQ(refinePose(stage().points, stage().scene, far, 0.05, 10).matrix, far.matrix);
}

TEST(Refine, APlaneKeepsWhatItDoesNotTell) {
  PointCloud plane;
  for (int i = 0; i < 900; ++i) {
    plane.points.emplace_back(0.01F * static_cast<float>(i % 30), 0.01F * static_cast<float>(i / 30), 1.F);
    plane.normals.emplace_back(0.F, 0.F, -1.F);
  }
  const Surface surface("plane", plane);
  const cv::Affine3d start(cv::Vec3d(0, 0, 0), cv::Vec3d(0.003, 0, 0.01));
  const cv::Affine3d found = refinePose(spreadPoints(surface, 300), surface, start, 0.05, 20);
  EXPECT_NEAR(found.translation()[2], 0, 1e-4);
  EXPECT_NEAR(found.translation()[0], 0.003, 1e-4);
}

TEST(SpreadPoints, AreAboutAsManyAsAskedFor) {
  for (const std::size_t count : {50U, 300U, 1000U}) {
    const std::size_t got = spreadPoints(stage().scene, count).points.size();
    EXPECT_LE(got, count);
    EXPECT_GT(got, count * 8 / 10);
  }
  EXPECT_EQ(spreadPoints(stage().model, 1000000).points.size(), stage().model.size());
}

TEST(InlierCounts, TellsTheTruePoseFromOthers) {
  const InlierCounts right = countInliers(stage().points, stage().scene, stage().view, stage().truth, 0.005);
  EXPECT_GT(right.confidence(), 0.95);
  EXPECT_TRUE(isAccepted(right, 0.8));
  const InlierCounts beside = countInliers(stage().points, stage().scene, stage().view,
                                           shifted(stage().truth, {0.12, 0.05, 0}), 0.005);
  EXPECT_LT(beside.confidence(), 0.6);
  EXPECT_FALSE(isAccepted(beside, 0.8));
}

TEST(InlierCounts, InFrontOfASurfaceThereIsNothingAndBehindItNobodyKnows) {
  const InlierCounts front =
      countInliers(stage().points, stage().scene, stage().view, shifted(stage().truth, {0, 0, -0.2}), 0.005);
  EXPECT_GT(front.seenThrough, front.facing * 9 / 10);
  EXPECT_FALSE(isAccepted(front, 0));
  const InlierCounts behind =
      countInliers(stage().points, stage().scene, stage().view, shifted(stage().truth, {0, 0, 0.2}), 0.005);
  EXPECT_GT(behind.occluded, behind.facing * 8 / 10);
  EXPECT_FALSE(isAccepted(behind, 0.5));
}

TEST(GlobalVerification, KeepsTheTruePoseAlone) {
  const std::vector<cv::Affine3d> poses{
      shifted(stage().truth, {0.13, 0.02, 0}), stage().truth, shifted(stage().truth, {0.004, 0, 0}),
      shifted(stage().truth, {-0.1, -0.12, 0.03}), shifted(stage().truth, {0, 0, 3})};
  const OrientedPoints points = spreadPointsBy(stage().model, 0.006);
  const auto parts = smoothPartsOf(stage().scene, 0.012);
  std::vector<bool> kept = verifyGlobally(points, stage().scene, stage().view, parts, poses, 0.006);
  EXPECT_EQ(kept, (std::vector<bool>{false, true, false, false, false}));
  EXPECT_EQ(kept, verifyGlobally(points, stage().scene, stage().view, parts, poses, 0.006));
  EXPECT_TRUE(verifyGlobally(points, stage().scene, stage().view, parts, {}, 0.006).empty());
}

TEST(SmoothParts, EndAtEdges) {
  PointCloud roof;  // two planes that meet
  for (int i = 0; i < 400; ++i) {
    const float x = 0.01F * static_cast<float>(i % 20), y = 0.01F * static_cast<float>(i / 20);
    roof.points.emplace_back(x + 0.01F, y, 1.F + x);
    roof.normals.emplace_back(0.7071F, 0.F, -0.7071F);
    roof.points.emplace_back(-x - 0.01F, y, 1.F + x);
    roof.normals.emplace_back(-0.7071F, 0.F, -0.7071F);
  }
  const Surface surface("roof", roof);
  const std::vector<int> parts = smoothPartsOf(surface, 0.03);
  EXPECT_NE(parts[0], parts[1]);
  for (std::size_t i = 2; i < parts.size(); ++i) EXPECT_EQ(parts[i], parts[i % 2]);
  EXPECT_EQ(parts, smoothPartsOf(surface, 0.03, 3));
}

TEST(RangeImage, KnowsWhatTheSensorSaw) {
  const std::vector<cv::Point3f> wall = [] {
    std::vector<cv::Point3f> points;
    for (int i = 0; i < 10000; ++i)
      points.emplace_back(0.01F * static_cast<float>(i % 100) - 0.5F,
                          0.01F * static_cast<float>(i / 100) - 0.5F, 2.F);
    return points;
  }();
  const RangeImage view(wall, 0.01);
  ASSERT_TRUE(view.known());
  ASSERT_TRUE(view.depth({0.1F, 0.1F, 1.F}));
  EXPECT_FLOAT_EQ(*view.depth({0.1F, 0.1F, 1.F}), 2.F);
  EXPECT_FALSE(view.depth({3.F, 0.F, 2.F}));
  EXPECT_FALSE(view.depth({0.F, 0.F, -1.F}));
  const std::vector<cv::Point3f> around{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
  EXPECT_FALSE(RangeImage(around, 0.01).known());
  EXPECT_FALSE(RangeImage({}, 0.01).known());
}

}  // namespace
}  // namespace estancia
