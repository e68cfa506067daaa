// Clusters of clouds, with a grid and without; what is flat.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "estancia/segmentation/clusters.hpp"
#include "made_up_scene.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::bowl;
using test::box;
using test::FailsWith;
using test::level;
using test::see;
using test::Seen;
using test::View;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using test::quietNan;

View lookingAtATable() {
  View view;
  view.camera = view.camera.scaledTo(320, 240);
  return view;
}
const View tableView = lookingAtATable();

Seen tableWithTwoThings() {
  return see({level(0), box({-0.12, 0, 0}, {0.16, 0.1, 0.12}, 0.5), bowl({0.15, 0, 0.06}, 0.06, 1)},
             tableView);
}

PointCloud without(PointCloud cloud, bool grid) {
  if (!grid) cloud.width = cloud.points.size(), cloud.height = 1;
  return cloud;
}

using test::cloudOf;

/// How many of a cluster's points are a shape's, and how many the shape has.
double looseOverlap(const Cluster& cluster, const Seen& seen, int shape) {
  std::size_t both = 0;
  for (const std::uint32_t p : cluster.points) both += seen.shape.ptr<int>()[p] == shape ? 1 : 0;
  const auto size = static_cast<std::size_t>(cv::countNonZero(seen.shape == shape));
  return static_cast<double>(both) / static_cast<double>(size + cluster.points.size() - both);
}

double bestLooseOverlap(const Clusters& found, const Seen& seen, int shape) {
  double best = 0;
  for (const Cluster& cluster : found.clusters) best = std::max(best, looseOverlap(cluster, seen, shape));
  return best;
}

TEST(CloudClusters, OrganizedAsTheImageItCameFrom) {
  const Seen seen = tableWithTwoThings();
  const PointCloud cloud = backProject(seen.depth, tableView.camera);
  const Clusters found = findClusters(cloud), image = findClusters(seen.depth, tableView.camera);
  ASSERT_THAT(found.planes, SizeIs(1));
  ASSERT_EQ(found.clusters.size(), image.clusters.size());
  for (std::size_t i = 0; i < found.clusters.size(); ++i) {
    EXPECT_EQ(found.clusters[i].points, image.clusters[i].points);
    EXPECT_EQ(found.clusters[i].box, image.clusters[i].box);
  }
}

TEST(CloudClusters, WithoutAGrid) {
  const Seen seen = tableWithTwoThings();
  const PointCloud cloud = without(backProject(seen.depth, tableView.camera), false);
  ClusterOptions options;
  options.threads = 1;
  const Clusters found = findClusters(cloud, options);
  ASSERT_THAT(found.planes, SizeIs(1));
  EXPECT_NEAR(found.planes.front().offset, -tableView.from[2], 0.01);
  EXPECT_THAT(found.clusters, SizeIs(2));
  EXPECT_GT(bestLooseOverlap(found, seen, 1), 0.75);
  EXPECT_GT(bestLooseOverlap(found, seen, 2), 0.75);
  for (const Cluster& cluster : found.clusters) {
    EXPECT_TRUE(std::ranges::is_sorted(cluster.points));
    EXPECT_EQ(cluster.box, cv::Rect());
    EXPECT_FALSE(cluster.atBorder);
    EXPECT_FALSE(cluster.flat);
    for (const std::uint32_t p : cluster.points) ASSERT_TRUE(isFinite(cloud.points[p]));
  }
  options.threads = 3;
  const Clusters again = findClusters(cloud, options);
  ASSERT_EQ(again.clusters.size(), found.clusters.size());
  for (std::size_t i = 0; i < found.clusters.size(); ++i)
    EXPECT_EQ(again.clusters[i].points, found.clusters[i].points);
}

TEST(CloudClusters, AGridThatNoPinholeCameraSawIsNone) {
  const Seen seen = tableWithTwoThings();
  PointCloud cloud = backProject(seen.depth, tableView.camera);
  for (cv::Point3f& p : cloud.points) p = {p.x, -p.z, p.y};  // turned: as a map has it
  cloud.viewpoint.emplace();
  const Clusters found = findClusters(cloud);
  EXPECT_THAT(found.planes, SizeIs(1));
  EXPECT_GT(bestLooseOverlap(found, seen, 1), 0.7);
  for (const Cluster& cluster : found.clusters) EXPECT_EQ(cluster.box, cv::Rect());
}

TEST(CloudClusters, NothingIsNoError) {
  ClusterOptions options;
  options.minPoints = 1;
  EXPECT_THAT(findClusters(PointCloud(), options).clusters, IsEmpty());
  EXPECT_THAT(findClusters(cloudOf({{quietNan, 0, 0}, {0, quietNan, 1}}), options).clusters, IsEmpty());
  EXPECT_THAT(findClusters(cloudOf(std::vector(6, cv::Point3f(0, 0, 0))), options).clusters, IsEmpty())
      << "not measured";
  for (const std::size_t count : {1, 2, 1000}) {
    const Clusters found = findClusters(cloudOf(std::vector(count, cv::Point3f(1, 2, 3))), options);
    EXPECT_THAT(found.planes, IsEmpty());
    ASSERT_THAT(found.clusters, SizeIs(1)) << count;
    EXPECT_THAT(found.clusters.front().points, SizeIs(count));
    EXPECT_FALSE(found.clusters.front().flat);
  }
  EXPECT_THAT(findClusters(cloudOf({{-3e38F, 0, 0}, {3e38F, 1, 0}, {0, 0, 2e9F}}), options).clusters,
              IsEmpty());
  options.minPoints = 3;
  EXPECT_THAT(findClusters(cloudOf({{-1, 0, 0}, {1, 1, 0}}), options).clusters, IsEmpty());
}

TEST(CloudClusters, RefusesAnUnsoundCloud) {
  PointCloud cloud = cloudOf({{0, 0, 1}, {0, 1, 1}});
  cloud.colors.resize(1);
  EXPECT_THAT([&] { findClusters(cloud); }, FailsWith(ErrorCode::invalidInput));
  cloud.colors.clear();
  cloud.width = 3;
  EXPECT_THAT([&] { findClusters(cloud); }, FailsWith(ErrorCode::invalidInput));
}

TEST(PointsOf, TakesColorsAndNormalsAlong) {
  PointCloud cloud = cloudOf({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  cloud.width = cloud.height = 2;
  cloud.colors = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {quietNan, quietNan, quietNan}};
  cloud.viewpoint = Pose{1, 2, 3};
  const PointCloud part = pointsOf(cloud, {0, 2});
  EXPECT_EQ(part.width, 2U);
  EXPECT_FALSE(part.organized());
  EXPECT_EQ(part.points, (std::vector<cv::Point3f>{{1, 0, 0}, {3, 0, 0}}));
  EXPECT_EQ(part.colors, (std::vector<cv::Vec3b>{{1, 0, 0}, {3, 0, 0}}));
  EXPECT_EQ(part.normals, (std::vector<cv::Point3f>{{0, 0, 1}, {1, 0, 0}}));
  EXPECT_EQ(part.viewpoint->y, 2);
  EXPECT_THAT(pointsOf(cloud, {}).points, IsEmpty());
  const std::vector<std::uint32_t> beyond{1, 4};
  EXPECT_THAT([&] { pointsOf(cloud, beyond); }, FailsWith(ErrorCode::invalidInput));
}

TEST(IsFlat, OnePlaneWithinNoise) {
  cv::RNG random(5);
  const auto sheet = [&](double away, double noise, double bend) {
    std::vector<cv::Point3f> points;
    for (int i = 0; i < 4000; ++i) {
      const double x = random.uniform(-0.1, 0.1), y = random.uniform(-0.1, 0.1);
      points.emplace_back(x, y, away + 0.3 * x + bend * std::abs(y) + random.gaussian(noise));
    }
    return cloudOf(std::move(points));
  };
  EXPECT_TRUE(isFlat(sheet(1, 0.0014, 0)));
  EXPECT_TRUE(isFlat(sheet(2, 0.0014 * 4, 0)));  // noise grows with the square of the distance
  EXPECT_FALSE(isFlat(sheet(1, 0.0014 * 4, 0)));
  EXPECT_FALSE(isFlat(sheet(1, 0.0014, 0.5)));  // two faces
  PointCloud holed = sheet(1, 0.0014, 0);
  for (std::size_t i = 0; i < holed.points.size(); i += 3) holed.points[i].z = quietNan;
  EXPECT_TRUE(isFlat(holed));
  PointCloud far = sheet(1, 0.0014 * 4, 0);
  far.viewpoint = Pose{0, 0, -1};
  EXPECT_TRUE(isFlat(far));
}

}  // namespace
}  // namespace estancia
