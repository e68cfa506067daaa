// The search for neighbors beside looking at every point.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/neighbors.hpp"
#include "support/numbers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace estancia {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

using test::quietNan;
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

}  // namespace
}  // namespace estancia
