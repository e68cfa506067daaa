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

}  // namespace
}  // namespace estancia
