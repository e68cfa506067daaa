// The voxel grid beside PCL's, and where PCL's has to give up.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/voxel_grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/files/cloud_file.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

#ifdef ESTANCIA_HAS_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#endif

namespace estancia {
namespace {

using test::FailsWith;

using test::quietNan;

using test::cloudOf;

TEST(VoxelGrid, MeansOfPointsColorsAndNormals) {
  PointCloud cloud = cloudOf({{1.2F, 0.5F, -0.5F}, {-0.1F, 0, 0}, {1.6F, 0.7F, -0.7F}, {quietNan, 1, 1}});
  for (const int c : {10, 20, 13, 99}) cloud.colors.emplace_back(c, 255 - c, 0);
  cloud.normals = {{1, 0, 0}, {quietNan, quietNan, quietNan}, {0, 1, 0}, {0, 0, 1}};
  const PointCloud grid = voxelGrid(cloud, 1);
  ASSERT_EQ(grid.points.size(), 2U);
  EXPECT_EQ(grid.width, 2U);
  EXPECT_LT(cv::norm(grid.points[0] - cv::Point3f(1.4F, 0.6F, -0.6F)), 1e-6);
  EXPECT_EQ(grid.points[1], cv::Point3f(-0.1F, 0, 0));
  EXPECT_EQ(grid.colors[0], cv::Vec3b(12, 244, 0));  // rounded
  EXPECT_FLOAT_EQ(grid.normals[0].x, std::sqrt(0.5F));
  EXPECT_FLOAT_EQ(grid.normals[0].y, std::sqrt(0.5F));
  EXPECT_TRUE(std::isnan(grid.normals[1].x));
  cloud.normals = {{1, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(std::isnan(voxelGrid(cloud, 1).normals[0].x));  // no direction wins
}

TEST(VoxelGrid, NoExtentIsTooLarge) {
  const PointCloud cloud = cloudOf({{-3e38F, 0, 0}, {3e38F, 0, 1e-7F}, {3e38F, 0, 3e38F}, {0, 0, 0}});
  EXPECT_EQ(voxelGrid(cloud, 1e-6).points, cloud.points);
  EXPECT_EQ(voxelGrid(cloud, 1e38).points.size(), 4U);
}

TEST(VoxelGrid, EdgeOfZeroIsOneVoxel) {
  const PointCloud cloud = cloudOf({{0, 0.1F, 0.1F}, {-0.F, 0.1F, 0.1F}});
  EXPECT_EQ(voxelGrid(cloud, 1).points.size(), 1U);
}

TEST(VoxelGrid, RefusesLeavesThatAreNone) {
  const PointCloud cloud = cloudOf({{0, 0, 0}});
  for (const double leaf : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THAT([&] { voxelGrid(cloud, leaf); }, FailsWith(ErrorCode::invalidOption)) << leaf;
  EXPECT_THAT([&] { findLeaf(cloud, 0); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { findLeaf({}, 3); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { findLeaf(cloudOf({{quietNan, 0, 0}}), 3); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_TRUE(voxelGrid({}, 1).points.empty());
}

TEST(VoxelGrid, FindsTheLeafForANumberOfPoints) {
  PointCloud plane;
  for (int i = 0; i < 40000; ++i) {
    const int row = i / 200;
    plane.points.emplace_back(0.01F * static_cast<float>(i % 200), 0.01F * static_cast<float>(row), 1.F);
  }
  plane = withGaussianNoise(cloudOf(plane.points), 0.002, 5);
  for (const double scale : {1.0, 1000.0}) {  // meters, millimeters
    PointCloud scaled = plane;
    for (cv::Point3f& p : scaled.points) p *= scale;
    for (const std::size_t wanted : {10U, 500U, 10000U}) {
      const Leaf leaf = findLeaf(scaled, wanted);
      EXPECT_EQ(voxelGrid(scaled, leaf.size).points.size(), leaf.points);
      EXPECT_NEAR(static_cast<double>(leaf.points), static_cast<double>(wanted),
                  0.002 * static_cast<double>(wanted));
    }
  }
  EXPECT_EQ(findLeaf(plane, 1000000).points, 40000U);  // more than there are
  EXPECT_EQ(findLeaf(cloudOf(std::vector<cv::Point3f>(50, {1, 2, 3})), 7).points, 1U);
  EXPECT_EQ(findLeaf(cloudOf({{1, 2, 3}}), 1).points, 1U);
}

#ifdef ESTANCIA_HAS_PCL
TEST(VoxelGrid, LeavesThePointsThatPclDoes) {
  const auto data = test::findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  for (const auto& file : {*data / "scenes/scene001.pcd", *data / "meshes/mario000_0.ply"}) {
    const PointCloud cloud = readCloud(file);
    pcl::PointCloud<pcl::PointXYZ>::Ptr theirs(new pcl::PointCloud<pcl::PointXYZ>);
    for (const cv::Point3f& p : cloud.points) theirs->push_back({p.x, p.y, p.z});
    theirs->is_dense = false;
    for (const float leaf : {0.00337F, 0.0137F}) {
      pcl::VoxelGrid<pcl::PointXYZ> filter;
      filter.setInputCloud(theirs);
      filter.setLeafSize(leaf, leaf, leaf);
      pcl::PointCloud<pcl::PointXYZ> filtered;
      filter.filter(filtered);
      const Neighbors ours(voxelGrid(cloud, leaf).points);
      ASSERT_EQ(ours.size(), filtered.size()) << file << " " << leaf;
      std::vector<Neighbor> buffer;
      float largest = 0;
      for (const auto& p : filtered)
        largest = std::max(largest, ours.nearest({p.x, p.y, p.z}, 1, buffer)[0].squared);
      EXPECT_LT(std::sqrt(largest), 3e-6) << file << " " << leaf;  // they sum in single precision
    }
  }
}
#endif

}  // namespace
}  // namespace estancia
