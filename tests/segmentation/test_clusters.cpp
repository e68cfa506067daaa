// Objects of made-up scenes in depth images.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/clusters.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "made_up_scene.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::board;
using test::bowl;
using test::box;
using test::FailsWith;
using test::level;
using test::see;
using test::Seen;
using test::Shape;
using test::View;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using test::quietNan;
const View kView;
const Shape table = level(0);
const Shape kBox = box({0, 0, 0}, {0.16, 0.1, 0.12}, 0.5);

/// Intersection over union of a cluster and a shape.
double overlap(const Cluster& cluster, const Seen& seen, int shape) {
  std::size_t both = 0, size = 0;
  for (const std::uint32_t p : cluster.points) both += seen.shape.ptr<int>()[p] == shape ? 1 : 0;
  for (std::size_t p = 0; p < seen.shape.total(); ++p) size += seen.shape.ptr<int>()[p] == shape ? 1 : 0;
  return static_cast<double>(both) / static_cast<double>(size + cluster.points.size() - both);
}

double bestOverlap(const Clusters& found, const Seen& seen, int shape) {
  double best = 0;
  for (const Cluster& cluster : found.clusters) best = std::max(best, overlap(cluster, seen, shape));
  return best;
}

bool same(const Clusters& a, const Clusters& b) {
  const auto samePlane = [](const Plane& p, const Plane& q) {
    return p.normal == q.normal && p.offset == q.offset && p.area == q.area;
  };
  const auto sameCluster = [](const Cluster& c, const Cluster& d) {
    return c.points == d.points && c.box == d.box && c.center == d.center && c.atBorder == d.atBorder &&
           c.flat == d.flat;
  };
  return std::ranges::equal(a.planes, b.planes, samePlane) &&
         std::ranges::equal(a.clusters, b.clusters, sameCluster);
}

TEST(Clusters, BoxOnATable) {
  const Seen seen = see({level(0, 0.3, 0.3), kBox});
  const Clusters found = findClusters(seen.depth, kView.camera);
  ASSERT_THAT(found.planes, SizeIs(1));
  const Plane& plane = found.planes.front();
  const cv::Vec3d up = seen.toScene * plane.normal;
  EXPECT_LT(cv::norm(up - cv::Vec3d(0, 0, 1)), 0.01);  // towards the camera
  EXPECT_NEAR(plane.offset, -kView.from[2], 0.005);    // it stands so high above
  double area = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const cv::Vec3d ray(kView.camera.slopeX(u), kView.camera.slopeY(v), 1);
      const double z = seen.depth.at<float>(v, u);
      if (seen.shape.at<int>(v, u) == 0) area += z * z / (525 * 525) / std::abs((seen.toScene * ray)[2]);
    }
  EXPECT_NEAR(plane.area, area, 0.08 * area);  // its rim has no normals
  ASSERT_THAT(found.clusters, SizeIs(1));
  const Cluster& cluster = found.clusters.front();
  EXPECT_GT(overlap(cluster, seen, 1), 0.9);
  EXPECT_TRUE(std::ranges::is_sorted(cluster.points));
  EXPECT_FALSE(cluster.atBorder);
  EXPECT_FALSE(cluster.flat);
  cv::Point3d sum;
  int left = 640, right = 0, top = 480, bottom = 0;
  for (const std::uint32_t p : cluster.points) {
    const int u = static_cast<int>(p) % 640, v = static_cast<int>(p) / 640;
    const double z = seen.depth.at<float>(v, u);
    sum += cv::Point3d(kView.camera.slopeX(u) * z, kView.camera.slopeY(v) * z, z);
    left = std::min(left, u), right = std::max(right, u), top = std::min(top, v),
    bottom = std::max(bottom, v);
  }
  EXPECT_EQ(cluster.box, cv::Rect(cv::Point(left, top), cv::Point(right + 1, bottom + 1)));
  EXPECT_LT(cv::norm(cv::Point3d(cluster.center) - sum / static_cast<double>(cluster.points.size())), 1e-5);
}

TEST(Clusters, ThingsOnEachOtherHollowOrBehindAPillarAreWhole) {
  const std::vector<Shape> scenes[] = {
      {table, box({0, 0, 0}, {0.26, 0.2, 0.1}, 0.4), box({0, 0.02, 0.1}, {0.1, 0.1, 0.1}, 0.9)},
      {table, bowl({0, 0, 0.1}, 0.1, 0.09)},
      {table, box({0, 0.15, 0}, {0.4, 0.08, 0.15}), box({0, -0.1, 0}, {0.06, 0.06, 0.3})}};
  for (const std::vector<Shape>& shapes : scenes) {
    const Seen seen = see(shapes);
    const Clusters found = findClusters(seen.depth, kView.camera);
    EXPECT_EQ(found.clusters.size() + 1, shapes.size()) << &shapes - scenes;
    for (int shape = 1; shape < static_cast<int>(shapes.size()); ++shape)
      EXPECT_GT(bestOverlap(found, seen, shape), &shapes == scenes ? 0.8 : 0.85) << &shapes - scenes;
  }
}

/// Each shape in a color of its own, and the table gray.
cv::Mat colorsOf(const Seen& seen, const std::vector<cv::Vec3b>& colors) {
  cv::Mat image(seen.depth.size(), CV_8UC3, cv::Scalar(90, 90, 90));
  for (std::size_t i = 0; i < colors.size(); ++i) {
    cv::Mat shape = seen.shape == static_cast<int>(i + 1);
    image.setTo(cv::Scalar(colors[i][0], colors[i][1], colors[i][2]), shape);
  }
  return image;
}

TEST(Clusters, ColorTellsTouchingBoxesOfOneHeightApart) {
  const Seen seen = see({table, box({-0.06, 0, 0}, {0.12, 0.1, 0.12}), box({0.06, 0, 0}, {0.12, 0.1, 0.12})});
  EXPECT_THAT(findClusters(seen.depth, kView.camera).clusters, SizeIs(1)) << "geometry is silent";
  const cv::Mat image = colorsOf(seen, {{40, 40, 200}, {200, 60, 40}});
  const Clusters found = findClusters(seen.depth, kView.camera, {}, image);
  EXPECT_THAT(found.clusters, SizeIs(2));
  EXPECT_GT(bestOverlap(found, seen, 1), 0.85);
  EXPECT_GT(bestOverlap(found, seen, 2), 0.85);
  cv::Mat half;
  cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_NEAREST);
  EXPECT_THAT(findClusters(seen.depth, kView.camera, {}, half).clusters, SizeIs(2)) << "of another size";
  const cv::Mat shadow = colorsOf(seen, {{200, 200, 200}, {130, 130, 130}});
  EXPECT_THAT(findClusters(seen.depth, kView.camera, {}, shadow).clusters, SizeIs(1))
      << "light alone is none";
}

TEST(Clusters, WallAndFloorAreNone) {
  View view;
  view.from = {0, -2, 1.2};
  view.to = {0, 0.5, 0.7};
  const Shape wall = board({0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 50, 50);
  const Seen seen = see({table, wall}, view);
  const Clusters found = findClusters(seen.depth, view.camera);
  EXPECT_THAT(found.planes, SizeIs(2));
  EXPECT_THAT(found.clusters, IsEmpty());
  const Seen withBox = see({table, wall, box({0.3, 0.6, 0}, {0.4, 0.3, 0.5}, 0.3)}, view);
  const Clusters more = findClusters(withBox.depth, view.camera);
  EXPECT_THAT(more.planes, SizeIs(2));
  ASSERT_THAT(more.clusters, SizeIs(1));
  EXPECT_GT(overlap(more.clusters.front(), withBox, 2), 0.8);
}

TEST(Clusters, ThingsAtTheBorder) {
  for (const double x : {-0.55, 0.55}) {
    const Seen seen = see({table, box({x, 0, 0}, {0.16, 0.1, 0.12}, 0.5)});
    Clusters found = findClusters(seen.depth, kView.camera);
    ASSERT_THAT(found.clusters, SizeIs(1));
    EXPECT_TRUE(found.clusters.front().atBorder);
    cv::Mat margin = seen.depth.clone();  // margin of cameras that match images in windows
    margin.colRange(0, 9) = 0;
    margin.colRange(631, 640) = 0;
    found = findClusters(margin, kView.camera);
    ASSERT_THAT(found.clusters, SizeIs(1));
    EXPECT_TRUE(found.clusters.front().atBorder);
  }
  const Seen alone = see({kBox});  // nothing around it
  const Clusters found = findClusters(alone.depth, kView.camera);
  ASSERT_THAT(found.clusters, SizeIs(1));
  EXPECT_FALSE(found.clusters.front().atBorder);
}

TEST(Clusters, LostRowsAndColumnsCutNothing) {
  const Seen whole = see({table, kBox});
  for (const int step : {480, 9}) {
    Seen seen{whole.depth.clone(), whole.shape.clone(), whole.toScene};
    for (int i = step / 2; i < 480; i += step) {
      seen.depth.row(i).setTo(0);
      seen.depth.col(i).setTo(0);
      seen.shape.row(i).setTo(-1);
      seen.shape.col(i).setTo(-1);
    }
    const Clusters found = findClusters(seen.depth, kView.camera);
    ASSERT_THAT(found.clusters, SizeIs(1)) << step;
    EXPECT_GT(overlap(found.clusters[0], seen, 1), 0.95) << step;
    for (const std::uint32_t p : found.clusters[0].points) ASSERT_GT(seen.depth.ptr<float>()[p], 0) << step;
  }
}

TEST(Clusters, SameForAnyThreadsAndSeedsFindTheSame) {
  const Seen seen = see({table, kBox, bowl({0.25, 0.1, 0.06}, 0.08, 0.09), level(0.3, 0.2, 0.1, -0.3, 0.4)});
  ClusterOptions options;
  options.threads = 1;
  const Clusters one = findClusters(seen.depth, kView.camera, options);
  ASSERT_GE(one.clusters.size(), 2U);
  for (const int threads : {3, 0}) {
    options.threads = threads;
    EXPECT_TRUE(same(findClusters(seen.depth, kView.camera, options), one)) << threads;
  }
  options.seed = 2;
  const Clusters other = findClusters(seen.depth, kView.camera, options);
  EXPECT_GT(bestOverlap(other, seen, 1), 0.9);
  EXPECT_GT(bestOverlap(other, seen, 2), 0.85);
}

/// Tiles of 12 pixels, each at another depth than those around it: some 1,800 segments.
TEST(Clusters, CrowdedImagesAreTheSameOnAnyThreads) {
  cv::Mat depth(480, 640, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const int column = u / 12, row = v / 12;
      depth.at<float>(v, u) = 0.6F * (1 + 0.02F * static_cast<float>((5 * column + 3 * row) % 13));
    }
  ClusterOptions options;
  options.minPoints = 1;
  options.threads = 1;
  const Clusters one = findClusters(depth, kView.camera, options);
  std::size_t points = 0;
  for (const Cluster& cluster : one.clusters) points += cluster.points.size();
  EXPECT_TRUE(one.planes.empty());
  EXPECT_GT(points, depth.total() / 2);  // tiles that are behind all around them are no things
  options.threads = 3;
  EXPECT_TRUE(same(findClusters(depth, kView.camera, options), one));
}

TEST(Clusters, EuclideanOnesAreWhatIsApart) {
  const cv::Vec3d size(0.08, 0.08, 0.1);
  const Seen seen = see({table, box({-0.26, 0, 0}, size), box({-0.14, 0, 0}, size), box({0.1, 0, 0}, size),
                         box({0.18, 0, 0}, {0.08, 0.08, 0.15})});
  ClusterOptions options{.method = ClusterOptions::Method::euclidean};
  const Clusters found = findClusters(seen.depth, kView.camera, options);
  ASSERT_THAT(found.clusters, SizeIs(3)) << "two of them touch";
  EXPECT_GT(bestOverlap(found, seen, 1), 0.7) << "but for the lowest 2 cm";
  EXPECT_LT(bestOverlap(found, seen, 3), 0.6);
  EXPECT_GT(overlap(found.clusters[0], seen, 4), 0.4);
  EXPECT_FALSE(found.clusters[0].atBorder || found.clusters[0].flat);
  options.minPoints = 100'000;
  EXPECT_THAT(findClusters(seen.depth, kView.camera, options).clusters, IsEmpty());
  options = {.method = ClusterOptions::Method::euclidean, .minPlaneArea = 1000};
  EXPECT_THAT(findClusters(seen.depth, kView.camera, options).clusters, IsEmpty())
      << "with the table they are more than 25,000 voxels";
  PointCloud loose;
  loose.points = {{0, 0, 1}, {0, 1, 1}};
  loose.width = 2;
  loose.height = 1;
  EXPECT_THAT([&] { findClusters(loose, options); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Clusters, OnlyAsSmallAsAskedFor) {
  const Seen seen = see({table, kBox});
  ClusterOptions options;
  const std::size_t size = findClusters(seen.depth, kView.camera).clusters.at(0).points.size();
  options.minPoints = size;
  EXPECT_THAT(findClusters(seen.depth, kView.camera, options).clusters, SizeIs(1));
  options.minPoints = size + 1;
  EXPECT_THAT(findClusters(seen.depth, kView.camera, options).clusters, IsEmpty());
}

TEST(Clusters, NothingIsNoError) {
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(1, 1), cv::Size(3, 2), cv::Size(1, 48)})
    for (const float z : {0.F, quietNan, -1.F, 1e30F, 1e-30F, std::numeric_limits<float>::infinity()}) {
      const Clusters found = findClusters(cv::Mat(size, CV_32F, cv::Scalar(z)), kView.camera);
      EXPECT_THAT(found.planes, IsEmpty()) << size << z;
      EXPECT_THAT(found.clusters, IsEmpty()) << size << z;
    }
  EXPECT_THAT(findClusters(see({table}).depth, kView.camera).clusters, IsEmpty());
}

TEST(Clusters, RefusesWhatIsNoDepthImageAndOptionsOutOfRange) {
  const cv::Mat depth(48, 64, CV_32F, cv::Scalar(1));
  const auto refusal = [](const cv::Mat& image, const CameraIntrinsics& camera,
                          const ClusterOptions& options = {}, const cv::Mat& bgr = {}) {
    return test::caught([&] { findClusters(image, camera, options, bgr); });
  };
  EXPECT_THAT(refusal({}, kView.camera), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusal(cv::Mat(48, 64, CV_16U), kView.camera), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusal(depth, kView.camera, {}, cv::Mat(48, 64, CV_8U)), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(refusal(depth, {}), FailsWith(ErrorCode::invalidInput));
  for (const double focal : {0., std::nan("")}) {
    CameraIntrinsics camera = kView.camera;
    camera.fx = focal;
    EXPECT_THAT(refusal(depth, camera), FailsWith(ErrorCode::invalidInput)) << focal;
  }
  for (const double area : {0., -1., std::nan(""), HUGE_VAL}) {
    ClusterOptions options;
    options.minPlaneArea = area;
    EXPECT_THAT(refusal(depth, kView.camera, options), FailsWith(ErrorCode::invalidOption)) << area;
    EXPECT_THAT([&] { findClusters(PointCloud(), options); }, FailsWith(ErrorCode::invalidOption)) << area;
  }
  ClusterOptions options;
  options.threads = -1;
  EXPECT_THAT(refusal(depth, kView.camera, options), FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
