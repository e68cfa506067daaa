// Rooms that are made up: what bounds them is no cluster, furniture is one, and things on it stay apart.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <set>
#include <vector>

#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"
#include "made_up_scene.hpp"

namespace estancia {
namespace {

using test::board;
using test::bowl;
using test::box;
using test::level;
using test::see;
using test::Seen;
using test::Shape;
using test::View;
using ::testing::SizeIs;

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
