// Neighbors of points, and the normals that they give.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/neighbors.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <random>

#include "estancia/cloud/normals.hpp"
#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#endif

namespace estancia {
namespace {

using test::FailsWith;
using test::quietNan;
using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::Truly;

constexpr float inf = std::numeric_limits<float>::infinity();

/// `count` points of a bent surface, scaled and moved; every seventh has a coordinate that is not finite.
std::vector<cv::Point3f> surface(std::size_t count, float scale = 1, float away = 0) {
  std::mt19937 random(7);
  const auto draw = [&] { return static_cast<float>(random()) / 4294967296.F; };
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i < count; ++i) {
    const float u = draw(), v = draw() * draw();  // denser on one side
    points.emplace_back(away + scale * u, away + scale * v, away + scale * (1 + u * u - v * v));
    if (i % 7 == 3) points.back().y = i % 2 == 0 ? quietNan : -inf;
  }
  return points;
}

float squaredBetween(const cv::Point3f& a, const cv::Point3f& b) {
  const cv::Point3f d = a - b;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

std::vector<std::uint32_t> bruteWithin(const std::vector<cv::Point3f>& points, const cv::Point3f& place,
                                       float radius) {
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (squaredBetween(points[i], place) <= radius * radius) found.push_back(static_cast<std::uint32_t>(i));
  return found;
}

std::vector<std::uint32_t> sortedIndices(std::span<const Neighbor> found) {
  std::vector<std::uint32_t> indices;
  for (const Neighbor& n : found) indices.push_back(n.index);
  std::ranges::sort(indices);
  return indices;
}

class Surfaces : public ::testing::TestWithParam<std::tuple<std::size_t, float, float>> {};

TEST_P(Surfaces, TheSamePointsAsWhenAllAreLookedAt) {
  const auto [count, scale, away] = GetParam();
  const auto points = surface(count, scale, away);
  const Neighbors tree(points);
  std::vector<Neighbor> buffer;
  for (const float radius : {0.F, 0.03F * scale, 0.3F * scale, 10 * scale})
    for (std::size_t i = 0; i < count; i += 1 + count / 40) {
      const cv::Point3f place = points[i] + cv::Point3f(0, 0, i % 2 == 0 ? 0 : 0.02F * scale);
      EXPECT_EQ(sortedIndices(tree.within(place, radius, buffer)), bruteWithin(points, place, radius));
    }
}

TEST_P(Surfaces, TheNearestOnesAsWhenAllAreSorted) {
  const auto [count, scale, away] = GetParam();
  const auto points = surface(count, scale, away);
  const Neighbors tree(points);
  std::vector<Neighbor> buffer;
  for (const std::size_t wanted : {1U, 2U, 10U, 100U, 100000U})
    for (std::size_t i = 0; i < count; i += 1 + count / 40) {
      const cv::Point3f place = points[i] + cv::Point3f(0, 0.02F * scale, 0);
      if (!std::isfinite(place.y)) continue;
      std::vector<float> all, ours;
      for (const auto& p : points)
        if (const float d = squaredBetween(p, place); std::isfinite(d)) all.push_back(d);
      std::ranges::sort(all);
      all.resize(std::min(all.size(), wanted));
      for (const Neighbor& n : tree.nearest(place, wanted, buffer)) {
        ours.push_back(n.squared);
        EXPECT_EQ(n.squared, squaredBetween(points[n.index], place));
      }
      EXPECT_EQ(ours, all);
    }
}

// Far from the origin (a map's coordinates), in millimeters, of few points.
INSTANTIATE_TEST_SUITE_P(Clouds, Surfaces,
                         ::testing::Combine(::testing::Values(1, 33, 2000), ::testing::Values(1.F, 1000.F),
                                            ::testing::Values(0.F, 5000.F)));

TEST(Neighbors, OneTreeForAnyNumberOfThreads) {
  const auto points = surface(5000);
  const Neighbors one(points, 1), many(points, 5);
  EXPECT_TRUE(std::ranges::equal(one.order(), many.order()));
  EXPECT_EQ(one.size(), points.size() - (points.size() + 3) / 7);
  std::vector<std::vector<std::uint32_t>> found(points.size()), again(points.size());
  const auto into = [](auto& lists) {
    return [&lists](std::uint32_t i, std::span<const Neighbor> near) { lists[i] = sortedIndices(near); };
  };
  one.eachWithin(0.05F, 1, into(found));
  many.eachWithin(0.05F, 4, into(again));
  EXPECT_EQ(found, again);
  for (std::size_t i = 0; i < points.size(); i += 50)
    EXPECT_EQ(found[i], bruteWithin(points, points[i], 0.05F));
}

TEST(Neighbors, NothingIsNearNothing) {
  std::vector<Neighbor> buffer;
  const std::vector<cv::Point3f> holes(40, {quietNan, 0, 0}), one = {{1, 2, 3}};
  for (const auto& points : {std::vector<cv::Point3f>{}, holes}) {
    const Neighbors none(points);
    EXPECT_EQ(none.size(), 0U);
    EXPECT_THAT(none.within({0, 0, 0}, 1, buffer), IsEmpty());
    EXPECT_THAT(none.nearest({0, 0, 0}, 3, buffer), IsEmpty());
    none.eachWithin(1, 2, [](std::uint32_t, auto) { FAIL(); });
  }
  const Neighbors tree(one);
  for (const cv::Point3f& place :
       {cv::Point3f(quietNan, 2, 3), cv::Point3f(1, inf, 3), cv::Point3f(1, 2, 5)}) {
    EXPECT_THAT(tree.within(place, 1, buffer), IsEmpty());
    EXPECT_THAT(tree.nearest(place, 1, buffer, 1), IsEmpty());
  }
  EXPECT_THAT(tree.within({1, 2, 3}, quietNan, buffer), IsEmpty());
  EXPECT_THAT(tree.within({1, 2, 3}, -1, buffer), IsEmpty());
  EXPECT_THAT(tree.nearest({1, 2, 3}, 0, buffer), IsEmpty());
  EXPECT_THAT(tree.within({1, 2, 3}, inf, buffer), SizeIs(1));
}

bool isNone(const cv::Point3f& n) {
  return std::isnan(n.x) && std::isnan(n.y) && std::isnan(n.z);
}

std::vector<cv::Point3f> normalsOf(const std::vector<cv::Point3f>& points, const NormalOptions& options) {
  return estimateNormals(points, Neighbors(points), options);
}

NormalOptions within(double radius, int threads = 1) {
  NormalOptions options;
  options.radius = radius;
  options.threads = threads;
  return options;
}

std::vector<cv::Point3f> grid(int side, const cv::Point3f& start, const cv::Point3f& u,
                              const cv::Point3f& v) {
  std::vector<cv::Point3f> points;
  points.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side;
    points.push_back(start + static_cast<float>(i % side) * u + static_cast<float>(row) * v);
  }
  return points;
}

TEST(Normals, OfAPlaneTowardsTheViewpoint) {
  for (const float away : {0.F, 1000.F}) {  // equally exact far from the origin, except for its coordinates
    NormalOptions options = within(0.1);
    options.viewpoint = {away, away, 5};
    const auto normals = normalsOf(grid(40, {away, away, 0}, {0.015625F, 0, 0}, {0, 0.015625F, 0}), options);
    for (const cv::Point3f& n : normals) EXPECT_LT(cv::norm(n - cv::Point3f(0, 0, 1)), 1e-6);
    options.viewpoint.z = -5;
    options.radius = 0;
    options.neighbors = 8;
    const auto others = normalsOf(grid(40, {away, away, 0}, {0.015625F, 0, 0}, {0, 0.015625F, 0}), options);
    for (const cv::Point3f& n : others) EXPECT_LT(cv::norm(n - cv::Point3f(0, 0, -1)), 1e-6);
  }
}

TEST(Normals, OfASphereInAnyUnit) {
  for (const double scale : {1.0, 1000.0}) {
    std::mt19937 random(3);
    std::vector<cv::Point3f> points;
    while (points.size() < 8000) {
      const auto draw = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
      const cv::Point3d p(draw(), draw(), draw());
      if (p.dot(p) < 1 && p.dot(p) > 0.01) points.emplace_back(p * (scale / cv::norm(p)));
    }
    const auto normals = normalsOf(points, within(0.15 * scale));
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT(normals[i].dot(points[i]) / scale, -0.99);
    EXPECT_EQ(normals, normalsOf(points, within(0.15 * scale, 4)));
  }
}

TEST(Normals, AtOtherPlacesThanThePoints) {
  const Neighbors plane(grid(20, {0, 0, 1}, {0.1F, 0, 0}, {0, 0.1F, 0}));
  const std::vector<cv::Point3f> places = {{1.03F, 1.02F, 1.1F}, {50, 0, 1}, {quietNan, 0, 1}};
  const auto normals = estimateNormals(places, plane, within(0.3));
  EXPECT_LT(cv::norm(normals[0] - cv::Point3f(0, 0, -1)), 1e-5);
  EXPECT_TRUE(isNone(normals[1]));
  EXPECT_TRUE(isNone(normals[2]));
}

TEST(Normals, NoneWhereNoPlaneIs) {
  EXPECT_TRUE(normalsOf({}, within(1)).empty());
  EXPECT_THAT(normalsOf({{0, 0, 1}}, within(1)), Each(Truly(isNone)));
  EXPECT_THAT(normalsOf({{0, 0, 1}, {0.1F, 0, 1}}, within(1)), Each(Truly(isNone)));
  std::vector<cv::Point3f> line, same(100, {1, 2, 3});
  for (int i = 0; i < 100; ++i) line.push_back(static_cast<float>(i) * cv::Point3f(0.1F, 0.3F, -0.2F));
  EXPECT_THAT(normalsOf(line, within(3)), Each(Truly(isNone)));
  EXPECT_THAT(normalsOf(same, within(3)), Each(Truly(isNone)));
  NormalOptions nearest;
  nearest.neighbors = 10;
  EXPECT_THAT(normalsOf(same, nearest), Each(Truly(isNone)));
  for (const NormalOptions& wrong :
       {NormalOptions{}, NormalOptions{1, 5}, NormalOptions{-1}, within(HUGE_VAL)})
    EXPECT_THAT([&] { normalsOf(same, wrong); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Normals, OfOneSurfaceAreOnOneSide) {
  std::vector<cv::Point3f> points, normals;
  std::mt19937 random(5);
  for (int part = 0; part < 2; ++part)  // two balls
    for (int i = 0; i < 3000; ++i) {
      const double z = 1 - (2 * i + 1) / 3000.0, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
      const cv::Point3f p(cv::Vec3f(cv::Vec3d(r * std::cos(turn), r * std::sin(turn), z)));
      points.push_back(p + cv::Point3f(3, 0, 0) * static_cast<float>(part));
      normals.push_back(random() % 2 == 0 ? p : -p);
    }
  normals[77] = {std::numeric_limits<float>::quiet_NaN(), 0, 0};
  const std::vector<cv::Point3f> before = normals;
  orientConsistently(points, Neighbors(points), normals);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 77) continue;
    const std::size_t first = i / 3000 * 3000;
    EXPECT_GT(normals[i].dot(points[i] - cv::Point3f(first == 0 ? 0 : 3, 0, 0)) *
                  before[first].dot(points[first] - cv::Point3f(first == 0 ? 0 : 3, 0, 0)),
              0)
        << i;
  }
  normals.pop_back();
  EXPECT_THAT([&] { orientConsistently(points, Neighbors(points), normals); },
              test::FailsWith(ErrorCode::invalidInput));
}

TEST(PrincipalAxes, AsAnIterativeSolverHasThem) {
  cv::RNG random(4);
  for (int i = 0; i < 2000; ++i) {
    cv::Matx33d factor;
    for (double& v : factor.val) v = random.gaussian(1);
    for (int c = 0; c < 3; ++c) factor(0, c) *= std::pow(10, -i % 5);  // flatter and flatter
    const cv::Matx33d covariance = factor.t() * factor;
    cv::Vec3d values;
    cv::Matx33d vectors;
    cv::eigen(covariance, values, vectors);  // largest first
    const PrincipalAxes axes = principalAxes(covariance);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(axes.variances[static_cast<std::size_t>(k)], values[2 - k], 1e-10 * values[0]);
    const cv::Vec3d expected(vectors(2, 0), vectors(2, 1), vectors(2, 2));
    if (values[1] - values[2] > 1e-3 * values[0]) {
      EXPECT_NEAR(std::abs(axes.normal.dot(expected)), 1, 1e-9);
    }
  }
}

#ifdef ESTANCIA_HAS_PCL
TEST(Normals, AsPclHasThem) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const PointCloud cloud = readCloud(*data / "meshes/mario000_0.ply");
  pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>);
  for (const cv::Point3f& p : cloud.points) points->push_back({p.x, p.y, p.z});
  for (const double radius : {0.006, 0.02}) {
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setInputCloud(points);
    estimation.setRadiusSearch(radius);
    pcl::PointCloud<pcl::Normal> theirs;
    estimation.compute(theirs);
    const auto ours = normalsOf(cloud.points, within(radius));
    std::size_t apart = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const auto& n = theirs[i];
      ASSERT_EQ(isNone(ours[i]), std::isnan(n.normal_x)) << i;
      // They sum in single precision, and a point at the very radius may be in or out.
      if (!isNone(ours[i]) &&
          !(ours[i].dot({n.normal_x, n.normal_y, n.normal_z}) > std::cos(0.5 * CV_PI / 180)))
        ++apart;
    }
    EXPECT_LE(apart, ours.size() / 500);
  }
}
#endif

}  // namespace
}  // namespace estancia
