// Things on a table as a Kinect sees them, beside what people marked.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "estancia/segmentation/clusters.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

const CameraIntrinsics kCamera{640, 480, 525, 525, 319.5, 239.5};

cv::Mat depthOf(const fs::path& file) {
  cv::Mat depth;
  cv::imread(file, cv::IMREAD_UNCHANGED).convertTo(depth, CV_32F, 0.001);
  return depth;
}

struct Score {
  int objects = 0, found = 0, over = 0, under = 0;
  double overlap = 0;  ///< sum of the objects' best intersections over unions
};

/// An object is all its marked parts, of which other things may hide what lies between; over: two clusters
/// have a fifth of it each; under: it shares a cluster that has a fifth of another.
void score(const Clusters& clusters, const cv::Mat& depth, const cv::Mat& marks, Score& sum) {
  std::vector<int> objectOf(depth.total());
  std::map<int, std::size_t> sizes;
  for (std::size_t i = 0; i < objectOf.size(); ++i) {
    const int mark = marks.data[i];
    if (mark < 20 || !(depth.ptr<float>()[i] > 0)) continue;  // 10 · object + part; 0 and 1 are none
    objectOf[i] = mark / 10;
    ++sizes[mark / 10];
  }
  std::map<int, std::vector<std::pair<std::size_t, std::size_t>>> overlaps;  // pixels, of a cluster of
  for (const Cluster& cluster : clusters.clusters) {
    std::map<int, std::size_t> shared;
    for (const std::uint32_t p : cluster.points) ++shared[objectOf[p]];
    for (const auto& [object, pixels] : shared) overlaps[object].emplace_back(pixels, cluster.points.size());
    int large = 0;
    for (const auto& [object, size] : sizes) large += 5 * shared[object] >= size ? 1 : 0;
    sum.under += large > 1 ? large : 0;
  }
  for (const auto& [object, size] : sizes) {
    double best = 0;
    int large = 0;
    for (const auto& [pixels, whole] : overlaps[object]) {
      best = std::max(best, static_cast<double>(pixels) / static_cast<double>(size + whole - pixels));
      large += 5 * pixels >= size ? 1 : 0;
    }
    ++sum.objects;
    sum.found += best >= 0.5 ? 1 : 0;
    sum.over += large > 1 ? 1 : 0;
    sum.overlap += best;
  }
}

TEST(RealClusters, FindTheObjectsOnTables) {
  const auto data = test::findData("mosd_rgbd");
  ESTANCIA_NEEDS(data, "needs mosd_rgbd");
  Score sum;
  for (int scene = 0; scene < 45; ++scene) {
    const std::string name = (*data / "learn" / ("learn" + std::to_string(scene))).string();
    const cv::Mat depth = depthOf(name + "_depth.png");
    const cv::Mat marks = cv::imread(name + "_label.png", cv::IMREAD_UNCHANGED);
    ASSERT_FALSE(depth.empty() || marks.size() != depth.size()) << name;
    const Clusters clusters = findClusters(depth, kCamera);
    EXPECT_EQ(clusters.planes.size(), 1U) << name;
    score(clusters, depth, marks, sum);
  }
  EXPECT_EQ(sum.objects, 112);
  EXPECT_GE(sum.found, 107);  // 95 %
  EXPECT_LE(sum.over, 6);
  EXPECT_EQ(sum.under, 0);
  EXPECT_GE(sum.overlap, 0.94 * sum.objects);
}

TEST(RealClusters, FindThemByTheirPointsAloneToo) {
  const auto data = test::findData("mosd_rgbd");
  ESTANCIA_NEEDS(data, "needs mosd_rgbd");
  Score sum;
  for (int scene = 0; scene < 45; scene += 5) {
    const std::string name = (*data / "learn" / ("learn" + std::to_string(scene))).string();
    const cv::Mat depth = depthOf(name + "_depth.png");
    PointCloud cloud = backProject(depth, kCamera);
    cloud.width = cloud.points.size();
    cloud.height = 1;
    const Clusters clusters = findClusters(cloud);
    score(clusters, depth, cv::imread(name + "_label.png", cv::IMREAD_UNCHANGED), sum);
  }
  EXPECT_GE(sum.found, 0.9 * sum.objects);
}

/// Without marks: a room's walls, cupboards, floor and table are planes, and much stands on them.
TEST(RealClusters, TakeAKitchenApart) {
  const auto data = test::findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(data, "needs sevenscenes_redkitchen");
  for (const char* frame : {"000025", "000300", "000600", "000900"}) {
    cv::Mat depth = depthOf(*data / "frames" / ("frame-" + std::string(frame) + ".depth.png"));
    ASSERT_FALSE(depth.empty());
    depth.setTo(0, depth > 6);
    const Clusters clusters = findClusters(depth, {640, 480, 585, 585, 320, 240});
    EXPECT_GE(clusters.planes.size(), 3U) << frame;
    EXPECT_GE(clusters.clusters.size(), 15U) << frame;
    for (const Plane& plane : clusters.planes) {
      EXPECT_NEAR(cv::norm(plane.normal), 1, 1e-9);
      EXPECT_LT(plane.offset, 0);  // the camera is in front of it
    }
    EXPECT_LT(clusters.clusters.front().points.size(), 2 * depth.total() / 5) << frame << ", a table's";
  }
}

}  // namespace
}  // namespace estancia
