// The filters by name, and what each does with clouds that are hardly any.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estancia/cloud/resolution.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using test::quietNan;

FilterOptions filterBy(const std::string& method, std::size_t points) {
  FilterOptions options;
  options.method = method;
  options.points = points;
  options.gng.signalsPerInsertion = 100;
  return options;
}

PointCloud filtered(const PointCloud& cloud, const FilterOptions& options) {
  return filterCloud(cloud, options);
}

/// An organized plane with holes, a bit rough.
PointCloud plane() {
  PointCloud cloud;
  cloud.width = 80;
  cloud.height = 60;
  for (int i = 0; i < 4800; ++i) {
    const int row = i / 80;
    cloud.points.emplace_back(0.01F * static_cast<float>(i % 80), 0.01F * static_cast<float>(row), 1.F);
    if (i % 10 == 0) cloud.points.back().z = quietNan;
    cloud.colors.emplace_back(i % 256, 1, 2);
  }
  return withGaussianNoise(cloud, 0.002, 1);
}

TEST(Filter, NoneLeavesTheCloudAsItIs) {
  const PointCloud cloud = plane(), same = filtered(cloud, filterBy("none", 10));
  EXPECT_EQ(same.points.size(), cloud.points.size());
  EXPECT_EQ(same.colors, cloud.colors);
  EXPECT_TRUE(same.organized());
  EXPECT_TRUE(filtered({}, filterBy("none", 10)).points.empty());
}

TEST(Filter, LeavesSoManyPoints) {
  const std::size_t voxels = filtered(plane(), filterBy("voxel", 500)).points.size();
  EXPECT_NEAR(static_cast<double>(voxels), 500, 2);
  const FilteredCloud neurons = filterWithDetails(plane(), filterBy("gng", 300));
  EXPECT_EQ(neurons.cloud.points.size(), 300U);
  EXPECT_EQ(neurons.cloud.width, 300U);
  EXPECT_GT(neurons.gas.edges.size(), 300U);
  EXPECT_EQ(neurons.gas.stop, GngStop::neurons);
}

TEST(Filter, KeepsColorsWhereTheyWere) {
  PointCloud halves = plane();
  const cv::Vec3b left(10, 20, 30), right(200, 100, 0);
  for (std::size_t i = 0; i < 4800; ++i) halves.colors[i] = halves.points[i].x < 0.395F ? left : right;
  for (const char* method : {"voxel", "gng"}) {
    const PointCloud cloud = filtered(halves, filterBy(method, 500));
    ASSERT_EQ(cloud.colors.size(), cloud.points.size()) << method;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      const float x = cloud.points[i].x - 0.395F;
      if (std::abs(x) < 0.03F) continue;
      EXPECT_EQ(cloud.colors[i], x < 0 ? left : right) << method;
    }
  }
}

TEST(Filter, ALeafGoesBeforeTheNumberOfPoints) {
  FilterOptions options = filterBy("voxel", 10);
  options.leaf = 0.1;
  const std::size_t voxels = filtered(plane(), options).points.size();
  EXPECT_GT(voxels, 47U);  // 8 × 6, and some where the noise reaches into the next
  EXPECT_LT(voxels, 140U);
  for (const double leaf : {-1.0, std::nan(""), HUGE_VAL}) {
    options.leaf = leaf;
    EXPECT_THAT([&] { filtered(plane(), options); }, FailsWith(ErrorCode::invalidOption)) << leaf;
  }
}

TEST(Filter, RefusesOtherNamesTornCloudsAndNoPoints) {
  EXPECT_THAT([&] { filtered(plane(), filterBy("sieve", 5)); }, FailsWith(ErrorCode::unknownName));
  PointCloud holes;
  holes.points.assign(12, {quietNan, quietNan, quietNan});
  holes.width = 4;
  holes.height = 3;
  for (const char* method : {"voxel", "gng"})
    EXPECT_THAT([&] { filtered(holes, filterBy(method, 5)); }, FailsWith(ErrorCode::invalidInput)) << method;
  PointCloud torn = plane();
  torn.colors.pop_back();
  for (const Choice& filter : filterMethods())
    EXPECT_THAT([&] { filtered(torn, filterBy(filter.name, 5)); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
