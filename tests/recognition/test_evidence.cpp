// The dense pose search: nearest-neighbor fields, votes, and evidence.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "estancia/recognition/dense_search.hpp"
#include "estancia/recognition/distinct_poses.hpp"
#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/scales.hpp"
#include "recognition/made_up_surface.hpp"

namespace estancia {
namespace {

TEST(NearestField, KnowsTheNearestPointUpToACell) {
  const PointCloud sheet = test::wavySheet(60, 0.3);
  constexpr double cell = 0.004, reach = 0.02;
  const NearestField field(sheet.points, cell, reach, 2);
  const Neighbors tree(sheet.points);
  std::mt19937 random(3);
  const auto off = [&] { return 0.03F * (static_cast<float>(random()) / 4294967296.F - 0.5F); };
  int far = 0;
  for (int i = 0; i < 3000; ++i) {
    const cv::Point3f place = sheet.points[random() % sheet.points.size()] + cv::Point3f(off(), off(), off());
    double nearest = std::numeric_limits<double>::infinity();
    for (const cv::Point3f& p : sheet.points) nearest = std::min(nearest, cv::norm(p - place));
    const std::int32_t found = field.at(place);
    const double half = std::sqrt(3.0) / 2 * cell;  // from a cell's middle to its corner
    if (found == NearestField::none) {
      EXPECT_GT(nearest, reach - half);
      ++far;
    } else {
      EXPECT_LT(cv::norm(sheet.points[static_cast<std::size_t>(found)] - place), nearest + 2 * half + 1e-6);
    }
  }
  EXPECT_LT(far, 300);
  EXPECT_EQ(field.at({100, 0, 0}), NearestField::none);
  EXPECT_EQ(field.at({std::numeric_limits<float>::quiet_NaN(), 0, 0}), NearestField::none);
  EXPECT_EQ(NearestField().at({0, 0, 1}), NearestField::none);
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
  EXPECT_NEAR(aside.vote(), 0, 0.01);  // nobody looked there
}

TEST(PoseScore, RareNormalsWeighMore) {
  OrientedPoints points;
  for (int i = 0; i < 100; ++i) {
    points.points.emplace_back(0.01F * static_cast<float>(i), 0.F, 1.F);
    points.normals.push_back(i < 96 ? cv::Point3f(0, 0, -1) : cv::Point3f(-1, 0, 0));
  }
  balanceNormals(points);
  ASSERT_EQ(points.weights.size(), 100U);
  EXPECT_NEAR(points.weights[99] / points.weights[0], std::sqrt(96.0 / 4), 0.01);
  double sum = 0;
  for (const float w : points.weights) sum += w;
  EXPECT_NEAR(sum / 100, 1, 1e-4);
}

TEST(Evidence, GrowsWithTheRootOfTheAreaThatCouldBeSeen) {
  PoseScore half;
  half.facing = half.support = 0.5;
  EXPECT_NEAR(evidenceFor(half, 700, false), 0.5, 1e-9);
  EXPECT_NEAR(evidenceFor(half, 2800, false), 1, 1e-9);
  // Of a closed model half faces the sensor, and all of that is there.
  EXPECT_NEAR(evidenceFor(half, 1400, true), 1, 1e-9);
}

TEST(RefineInField, BringsASheetBack) {
  const Surface surface("sheet", test::wavySheet(120, 0.4, 1, 0));
  const NearestField field(surface.points(), 0.003, 0.03, 1);
  const RangeImage view(surface.points(), 0.005);
  OrientedPoints model;
  for (std::size_t i = 0; i < surface.size(); i += 20) {
    model.points.push_back(surface.points()[i]);
    model.normals.push_back(surface.normals()[i]);
  }
  const cv::Point3d middle(0, 0, 1.2);
  const cv::Affine3d turned = cv::Affine3d(cv::Vec3d(), cv::Vec3d(middle) + cv::Vec3d(0.006, -0.005, 0.004)) *
                              cv::Affine3d(cv::Vec3d(0.03, -0.02, 0.04)) *
                              cv::Affine3d(cv::Vec3d(), -cv::Vec3d(middle));
  const cv::Affine3d back = refineInField(model, middle, {surface, field, view}, turned, {0.02, 0.005, 30});
  EXPECT_LT(cv::norm(back * middle - middle), 0.0015);
  EXPECT_LT(cv::norm(back.rotation() - cv::Matx33d::eye()), 0.01);
  EXPECT_GT(cv::norm(turned * middle - middle), 0.008);
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

TEST(DistinctPoses, AreTheBestOfThoseThatAreAlike) {
  struct Posed {
    cv::Affine3d pose;
    int rank = 0;
  };
  const cv::Point3d center(1, 2, 3);
  // Turned by so much [rad] around the center, then moved.
  const auto posed = [&](double angle, double along, int rank) {
    const cv::Affine3d turn(cv::Vec3d(0, 0, angle));
    return Posed{turn.translate(cv::Vec3d(center - turn * center) + cv::Vec3d(along, 0, 0)), rank};
  };
  const std::vector<Posed> poses = {posed(0, 0, 0),   posed(0.1, 0.009, 1), posed(0.1, 0.011, 2),
                                    posed(0.2, 0, 3), posed(3.1, 0, 4),     posed(0.1, 0.012, 5)};
  const auto left = [&](double alike, std::size_t most = 9) {
    std::vector<int> ranks;
    for (const Posed& p : distinctPoses(poses, center, 0.01, alike, most)) ranks.push_back(p.rank);
    return ranks;
  };
  EXPECT_THAT(left(std::cos(0.15)), testing::ElementsAre(0, 2, 3, 4));
  EXPECT_THAT(left(std::cos(0.15), 2), testing::ElementsAre(0, 2));
  EXPECT_THAT(left(std::cos(0.05)), testing::ElementsAre(0, 1, 3, 4));
  EXPECT_THAT(left(kAnyRotation), testing::ElementsAre(0, 2));
  EXPECT_TRUE(distinctPoses(std::vector<Posed>(), center, 0.01, kAnyRotation).empty());
}

}  // namespace
}  // namespace estancia
