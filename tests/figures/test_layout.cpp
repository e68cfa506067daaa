// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estancia/figures/layout.hpp"
#include "support/report_map.hpp"

namespace estancia::report {
namespace {

using test::sampleMap;

double distance(const Point& a, const Point& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

void expectFiniteAndApart(const std::vector<Point>& points, double least) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(std::isfinite(points[i].x) && std::isfinite(points[i].y)) << "node " << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(distance(points[i], points[j]), least) << i << " and " << j;
  }
}

std::vector<Link> ring(std::size_t n) {
  std::vector<Link> links;
  for (std::size_t i = 0; i + 1 < n; ++i) links.push_back({i, i + 1, 1, 0});
  if (n > 2) links.push_back({0, n - 1, 1, 0});
  return links;
}

TEST(GraphLayout, ARingIsDrawnRound) {
  const auto points = layoutGraph(12, ring(12));
  expectFiniteAndApart(points, 0.3);
  Point center;
  for (const Point& p : points) center = {center.x + p.x / 12, center.y + p.y / 12};
  const double radius = distance(points[0], center);
  for (const Point& p : points) EXPECT_NEAR(distance(p, center), radius, 0.15 * radius);
}

TEST(GraphLayout, UnconnectedAndLonelyNodesFindAPlace) {
  expectFiniteAndApart(layoutGraph(6, {{0, 1, 1, 0}, {2, 3, 1, 1}}), 0.1);
  expectFiniteAndApart(layoutGraph(1, {}), 0);
  EXPECT_TRUE(layoutGraph(0, {}).empty());
}

TEST(Separation, NodesAtOnePlacePartAndStayInTheBox) {
  std::vector<Point> centers(15, Point{100, 100});
  const std::vector<double> radii(15, 10);
  separate(centers, radii, 4, {0, 0, 200, 200});
  expectFiniteAndApart(centers, 23.5);
  for (const Point& p : centers) {
    EXPECT_GE(std::min(p.x, p.y), 10);
    EXPECT_LE(std::max(p.x, p.y), 190);
  }
}

TEST(MapPlane, AMapInACamerasFrameIsSeenFromAbove) {
  const GroundPlane plane = planeOf({{0, 0, 0}, {3, 0.01, 1}, {-2, 0, 5}, {4, 0.02, 4}});  // y points down
  const Point p = plane.project({3, 7, 1});
  EXPECT_DOUBLE_EQ(p.x, 3);
  EXPECT_DOUBLE_EQ(p.y, 1);
}

TEST(MapPlane, ATiltedMapIsSeenAlongItsLeastSpread) {
  std::vector<cv::Vec3d> positions;  // a circle in the plane z = x + y
  positions.reserve(40);
  for (int i = 0; i < 40; ++i) positions.push_back({std::cos(i), std::sin(i), std::cos(i) + std::sin(i)});
  const GroundPlane plane = planeOf(positions);
  for (const auto& p : positions) {
    const Point flat = plane.project(p);
    EXPECT_NEAR(std::hypot(flat.x, flat.y), std::hypot(p[0], p[1], p[2]), 1e-9);
  }
  const double up = plane.right[0] * plane.up[1] - plane.right[1] * plane.up[0];
  EXPECT_GT(up, 0) << "the map is mirrored";
}

TEST(MapLayout, NodesWithoutPosesLieAmongTheirNeighbors) {
  TopologicalMap map = sampleMap();
  for (MappedFrame& frame : map.frames)
    if (frame.node == 2) frame.pose.reset();
  const MapLayout layout = layoutMap(summarize(map), false);
  EXPECT_TRUE(layout.metric);
  EXPECT_NEAR(layout.nodes[2].x, (layout.nodes[1].x + layout.nodes[3].x) / 2, 1e-9);
}

TEST(MapLayout, AbsurdPosesAreNoPlaces) {
  TopologicalMap map = sampleMap();
  map.frames[0].pose->x = std::numeric_limits<double>::quiet_NaN();
  map.frames[1].pose->y = 1e300;
  const MapLayout layout = layoutMap(summarize(map), false);
  EXPECT_FALSE(layout.frames[0].has_value());
  EXPECT_FALSE(layout.frames[1].has_value());
  expectFiniteAndApart(layout.nodes, 0.1);
}

}  // namespace
}  // namespace estancia::report
