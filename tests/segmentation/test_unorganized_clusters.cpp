// Clusters of clouds without an image, of real tables, and of furniture.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <vector>

#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"
#include "made_up_scene.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::board;
using test::bowl;
using test::box;
using test::FailsWith;
using test::level;
using test::quietNan;
using test::see;
using test::Seen;
using test::Shape;
using test::View;
using ::testing::IsEmpty;
using ::testing::SizeIs;

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

const CameraIntrinsics kCamera{640, 480, 525, 525, 319.5, 239.5};

cv::Mat depthOf(const fs::path& file) {
  cv::Mat depth;
  cv::imread(file, cv::IMREAD_UNCHANGED).convertTo(depth, CV_32F, 0.001);
  return depth;
}

struct Score {
  int objects = 0, found = 0;
  double overlap = 0;  ///< sum of the objects' best intersections over unions
};

/// An object is all its marked parts, of which other things may hide what lies between.
void score(const Clusters& clusters, const cv::Mat& depth, const cv::Mat& marks, Score& sum) {
  std::vector<int> objectOf(depth.total());
  std::map<int, std::size_t> sizes;
  for (std::size_t i = 0; i < objectOf.size(); ++i) {
    const int mark = marks.data[i];
    if (mark < 20 || !(depth.ptr<float>()[i] > 0)) continue;  // 10 · object + part; 0 and 1 are none
    objectOf[i] = mark / 10;
    ++sizes[mark / 10];
  }
  std::map<int, double> best;
  for (const Cluster& cluster : clusters.clusters) {
    std::map<int, std::size_t> shared;
    for (const std::uint32_t p : cluster.points) ++shared[objectOf[p]];
    for (const auto& [object, pixels] : shared)
      best[object] =
          std::max(best[object], static_cast<double>(pixels) /
                                     static_cast<double>(sizes[object] + cluster.points.size() - pixels));
  }
  for (const auto& [object, size] : sizes) {
    if (object == 0) continue;
    ++sum.objects;
    sum.found += best[object] >= 0.5 ? 1 : 0;
    sum.overlap += best[object];
  }
}

TEST(RealClusters, FindTheObjectsOnTablesInImagesAndByTheirPointsAlone) {
  const auto data = test::findData("mosd_rgbd");
  ESTANCIA_NEEDS(data, "needs mosd_rgbd");
  Score sum, alone;
  for (int scene = 0; scene < 45; scene += 5) {
    const std::string name = (*data / "learn" / ("learn" + std::to_string(scene))).string();
    const cv::Mat depth = depthOf(name + "_depth.png");
    const cv::Mat marks = cv::imread(name + "_label.png", cv::IMREAD_UNCHANGED);
    ASSERT_FALSE(depth.empty() || marks.size() != depth.size()) << name;
    const Clusters clusters = findClusters(depth, kCamera);
    EXPECT_EQ(clusters.planes.size(), 1U) << name;
    score(clusters, depth, marks, sum);
    PointCloud cloud = backProject(depth, kCamera);
    cloud.width = cloud.points.size();
    cloud.height = 1;
    score(findClusters(cloud), depth, marks, alone);
  }
  EXPECT_GE(sum.objects, 18);
  EXPECT_GE(sum.found, 0.95 * sum.objects);
  EXPECT_GE(sum.overlap, 0.94 * sum.objects);
  EXPECT_GE(alone.found, 0.9 * alone.objects);
}

/// Numbers of shapes that are one thing.
using Parts = std::set<int>;

double bestOverlapOf(const Clusters& found, const Seen& seen, const Parts& parts) {
  const auto* shape = seen.shape.ptr<int>();
  std::size_t size = 0;
  for (std::size_t p = 0; p < seen.shape.total(); ++p) size += parts.count(shape[p]);
  double best = 0;
  for (const Cluster& cluster : found.clusters) {
    std::size_t both = 0;
    for (const std::uint32_t p : cluster.points) both += parts.count(shape[p]);
    best =
        std::max(best, static_cast<double>(both) / static_cast<double>(size + cluster.points.size() - both));
  }
  return best;
}

/// The share of the pixels of some shapes that are in a cluster.
double clustered(const Clusters& found, const Seen& seen, const Parts& parts) {
  const auto* shape = seen.shape.ptr<int>();
  double all = 0, in = 0;
  for (std::size_t p = 0; p < seen.shape.total(); ++p) all += static_cast<double>(parts.count(shape[p]));
  for (const Cluster& cluster : found.clusters)
    for (const std::uint32_t p : cluster.points) in += static_cast<double>(parts.count(shape[p]));
  return in / all;
}

/// 0 floor, 1 and 2 walls, 3 to 7 a table, 8 and 9 things on it, 10 a cupboard at the wall.
const std::vector<Shape> room{level(0),
                              board({0, 3, 1.25}, {1, 0, 0}, {0, 0, 1}, 10, 1.25),
                              board({-2, 0, 1.25}, {0, 1, 0}, {0, 0, 1}, 10, 1.25),
                              box({0, 1.3, 0.66}, {1.2, 0.8, 0.04}),
                              box({-0.55, 0.95, 0}, {0.06, 0.06, 0.66}),
                              box({0.55, 0.95, 0}, {0.06, 0.06, 0.66}),
                              box({-0.55, 1.65, 0}, {0.06, 0.06, 0.66}),
                              box({0.55, 1.65, 0}, {0.06, 0.06, 0.66}),
                              box({-0.2, 1.2, 0.7}, {0.12, 0.12, 0.15}, 0.4),
                              box({0.3, 1.4, 0.7}, {0.25, 0.15, 0.1}, 1),
                              box({-1.2, 2.7, 0}, {0.8, 0.5, 1.1})};
const Parts bounds{0, 1, 2}, tableParts{3, 4, 5, 6, 7};

View inRoom() {
  View view;
  view.camera = {320, 240, 262.5, 262.5, 159.5, 119.5};
  view.from = {0.2, -1, 1.3};
  view.to = {-0.2, 1.5, 0.6};
  view.noise = 0.0012;
  return view;
}

void expectRoom(const Clusters& found, const Seen& seen) {
  EXPECT_GT(bestOverlapOf(found, seen, tableParts), 0.6);
  EXPECT_GT(bestOverlapOf(found, seen, {8}), 0.6);
  EXPECT_GT(bestOverlapOf(found, seen, {9}), 0.6);
  EXPECT_GT(bestOverlapOf(found, seen, {10}), 0.6);
  EXPECT_LT(clustered(found, seen, bounds), 0.03);
  EXPECT_LE(found.clusters.size(), 6U);
}

/// A cupboard along the wall, and a toaster on it, near its front edge.
TEST(Furniture, WhatStandsOnAWorktopNearEyeHeightIsAThing) {
  const std::vector<Shape> kitchen{
      level(0), board({0, 3, 1.25}, {1, 0, 0}, {0, 0, 1}, 10, 1.25), box({0, 2.7, 0}, {2.4, 0.6, 0.9}),
      box({0.2, 2.52, 0.9}, {0.3, 0.16, 0.2}, 0.1), box({-0.5, 2.6, 0.9}, {0.2, 0.3, 0.3}, -0.2)};
  View view = inRoom();
  view.from = {0.1, 0.6, 1.0};
  view.to = {0, 2.5, 0.8};
  const Seen seen = see(kitchen, view);
  const Clusters found = findClusters(seen.depth, view.camera);
  EXPECT_GT(bestOverlapOf(found, seen, {3}), 0.85);
  EXPECT_GT(bestOverlapOf(found, seen, {4}), 0.98);
}

TEST(Furniture, IsOneThingAndWhatStandsOnItAnother) {
  const View view = inRoom();
  const Seen seen = see(room, view);
  expectRoom(findClusters(seen.depth, view.camera), seen);
}

TEST(Furniture, IsFoundByATiltedCamera) {
  View view = inRoom();
  view.roll = 20 * CV_PI / 180;
  const Seen seen = see(room, view);
  expectRoom(findClusters(seen.depth, view.camera), seen);
}

TEST(Furniture, ThatFillsTheViewBearsThingsLikeAnyTable) {
  View view = inRoom();
  view.from = {0, 0.6, 1.3};
  view.to = {0, 1.3, 0.7};
  const Seen seen = see({box({0, 1.3, 0}, {4, 4, 0.7}), room[8], room[9]}, view);
  const Clusters found = findClusters(seen.depth, view.camera);
  ASSERT_THAT(found.planes, SizeIs(1));
  EXPECT_TRUE(found.planes.front().structural);
  EXPECT_THAT(found.clusters, SizeIs(2));
  EXPECT_GT(bestOverlapOf(found, seen, {1}), 0.6);
  EXPECT_GT(bestOverlapOf(found, seen, {2}), 0.6);
}

TEST(Furniture, TallAsARoomIsToldFromItsWalls) {
  const View view = inRoom();
  // A wardrobe as high as the room, beside whose front the wall is seen.
  const Seen seen = see({room[0], room[1], room[2], box({-1, 2.7, 0}, {1.2, 0.6, 2.5})}, view);
  const Clusters found = findClusters(seen.depth, view.camera);
  EXPECT_GT(bestOverlapOf(found, seen, {3}), 0.6);
  EXPECT_LT(clustered(found, seen, bounds), 0.03);
}

/// An image in which each shape has one color.
cv::Mat colored(const Seen& seen, const std::vector<cv::Vec3b>& colors) {
  cv::Mat image(seen.shape.size(), CV_8UC3, cv::Scalar(128, 128, 128));
  std::transform(seen.shape.begin<int>(), seen.shape.end<int>(), image.begin<cv::Vec3b>(), [&](int shape) {
    return shape < 0 ? cv::Vec3b() : colors[static_cast<std::size_t>(shape)];
  });
  return image;
}

TEST(Furniture, BooksBetweenItsBoardsAreToldByTheirColor) {
  View view = inRoom();
  view.from = {0.4, 0.9, 1.25};
  view.to = {0, 2.5, 1.2};
  // A bookcase: back, sides, two shelves, of which the lower is at eye height; books up to its front.
  const std::vector<Shape> shapes{
      level(0),
      board({0, 3, 1.25}, {1, 0, 0}, {0, 0, 1}, 10, 1.25),
      box({0, 2.88, 0}, {1, 0.02, 1.9}),
      box({-0.5, 2.75, 0}, {0.03, 0.28, 1.9}),
      box({0.5, 2.75, 0}, {0.03, 0.28, 1.9}),
      box({0, 2.75, 1.17}, {1, 0.28, 0.03}),
      box({0, 2.75, 1.6}, {1, 0.28, 0.03}),
      box({-0.37, 2.78, 1.2}, {0.22, 0.18, 0.25}),
  };
  const Parts books{7};
  const cv::Vec3b white(225, 230, 230), wall(150, 160, 150), red(50, 50, 150);
  const Seen seen = see(shapes, view);
  const cv::Mat image = colored(seen, {wall, wall, white, white, white, white, white, red}),
                alike = colored(seen, {wall, wall, white, white, white, white, white, white});
  EXPECT_GT(bestOverlapOf(findClusters(seen.depth, view.camera, {}, image), seen, books), 0.6);
  EXPECT_LT(bestOverlapOf(findClusters(seen.depth, view.camera, {}, alike), seen, books), 0.5);
}

TEST(Furniture, BearsAVaseWithItsFlowers) {
  View view = inRoom();
  view.to = {0, 1.3, 0.8};
  const std::vector<Shape> shapes{
      level(0), board({0, 3, 1.25}, {1, 0, 0}, {0, 0, 1}, 10, 1.25), box({0, 1.3, 0.66}, {1.4, 0.8, 0.04}),
      box({0, 1.3, 0.7}, {0.08, 0.08, 0.2}), bowl({0, 1.3, 1.04}, 0.16, HUGE_VAL)};
  view.from = {0.2, -0.5, 1.2};
  const Seen seen = see(shapes, view);
  const Clusters found = findClusters(seen.depth, view.camera);
  EXPECT_GT(bestOverlapOf(found, seen, {3, 4}), 0.95);
  EXPECT_GT(bestOverlapOf(found, seen, {2}), 0.8);
}

Plane planeOf(const cv::Vec3d& normal, double area) {
  Plane plane;
  plane.normal = cv::normalize(normal);
  plane.area = area;
  return plane;
}

TEST(Up, IsWhereMostPlanesAgree) {
  const double tilt = 20 * CV_PI / 180;
  const cv::Vec3d up(std::sin(tilt), -std::cos(tilt), 0), wall(std::cos(tilt), std::sin(tilt), 0);
  const std::vector<Plane> planes{planeOf(up, 2), planeOf({0, 0, -1}, 3), planeOf({0.5, -1, -0.7}, 1)};
  EXPECT_LT(cv::norm(upOf(planes) - up), 1e-6);
  EXPECT_LT(cv::norm(upOf({planeOf(wall, 1), planeOf({0, 0, -1}, 1)}) - up), 1e-6) << "walls alone tell";
  EXPECT_LT(cv::norm(upOf({planeOf(-up, 1)}) - up), 1e-6) << "so does a ceiling";
  EXPECT_EQ(upOf({}), cv::Vec3d(0, -1, 0));
  EXPECT_LT(cv::norm(upOf({planeOf({0, -0.2, -1}, 1)}) - cv::normalize(cv::Vec3d(0, -1, 0.2))), 1e-6)
      << "one wall: its upright is nearest to the image's";
}

}  // namespace
}  // namespace estancia
