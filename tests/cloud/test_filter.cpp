// Clouds with fewer points, and objects cut out of images or rendered from clouds.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/filter.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/cloud/color_lab.hpp"
#include "estancia/cloud/crop_object.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
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

using test::cloudOf;
using test::FailsWith;
using test::quietNan;
using Background = CropOptions::Background;

FilterOptions filterBy(const std::string& method, std::size_t points) {
  FilterOptions options;
  options.method = method;
  options.points = points;
  options.gng.signalsPerInsertion = 100;
  return options;
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
  const PointCloud cloud = plane(), same = filterCloud(cloud, filterBy("none", 10));
  EXPECT_EQ(same.points.size(), cloud.points.size());
  EXPECT_EQ(same.colors, cloud.colors);
  EXPECT_TRUE(same.organized());
  EXPECT_TRUE(filterCloud({}, filterBy("none", 10)).points.empty());
}

TEST(Filter, LeavesSoManyPoints) {
  const std::size_t voxels = filterCloud(plane(), filterBy("voxel", 500)).points.size();
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
    const PointCloud cloud = filterCloud(halves, filterBy(method, 500));
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
  const std::size_t voxels = filterCloud(plane(), options).points.size();
  EXPECT_GT(voxels, 47U);  // 8 × 6, and some where the noise reaches into the next
  EXPECT_LT(voxels, 140U);
  for (const double leaf : {-1.0, std::nan(""), HUGE_VAL}) {
    options.leaf = leaf;
    EXPECT_THAT([&] { filterCloud(plane(), options); }, FailsWith(ErrorCode::invalidOption)) << leaf;
  }
}

TEST(Filter, RefusesOtherNamesTornCloudsAndNoPoints) {
  EXPECT_THAT([&] { filterCloud(plane(), filterBy("sieve", 5)); }, FailsWith(ErrorCode::unknownName));
  PointCloud holes;
  holes.points.assign(12, {quietNan, quietNan, quietNan});
  holes.width = 4;
  holes.height = 3;
  for (const char* method : {"voxel", "gng"})
    EXPECT_THAT([&] { filterCloud(holes, filterBy(method, 5)); }, FailsWith(ErrorCode::invalidInput))
        << method;
  PointCloud torn = plane();
  torn.colors.pop_back();
  for (const Choice& filter : filterMethods())
    EXPECT_THAT([&] { filterCloud(torn, filterBy(filter.name, 5)); }, FailsWith(ErrorCode::invalidInput));
}

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

const cv::Vec3b kGray(128, 128, 128);

/// 40 × 30 pixels, each of which encodes its position.
cv::Mat places() {
  cv::Mat image(30, 40, CV_8UC3);
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u)
      image.at<cv::Vec3b>(v, u) = cv::Vec3b(static_cast<uchar>(u), static_cast<uchar>(v), 200);
  return image;
}

CropOptions with(Background background, double margin = 0, double crop = 0.875) {
  CropOptions options;
  options.background = background;
  options.margin = margin;
  options.crop = crop;
  return options;
}

TEST(Crop, MiddleOfTheSquareHoldsTheThing) {
  const cv::Mat patch = cropObject(places(), {10, 12, 14, 6});
  ASSERT_EQ(patch.size(), cv::Size(16, 16));  // 14 / 0.875
  EXPECT_EQ(patch.at<cv::Vec3b>(0, 0), cv::Vec3b(9, 7, 200));
  EXPECT_EQ(patch.at<cv::Vec3b>(15, 15), cv::Vec3b(24, 22, 200));
  EXPECT_EQ(cropObject(places(), {10, 12, 4, 8}, {}, with(Background::kept, 0, 1)).size(), cv::Size(8, 8));
  EXPECT_EQ(cropObject(places(), {10, 12, 4, 8}, {}, with(Background::kept, 0.25, 1)).size(),
            cv::Size(12, 12));
}

TEST(Crop, GrayBeyondTheImage) {
  const cv::Mat patch = cropObject(places(), {0, 0, 14, 14});
  ASSERT_EQ(patch.size(), cv::Size(16, 16));
  EXPECT_EQ(patch.at<cv::Vec3b>(0, 5), kGray);
  EXPECT_EQ(patch.at<cv::Vec3b>(5, 0), kGray);
  EXPECT_EQ(patch.at<cv::Vec3b>(1, 1), cv::Vec3b(0, 0, 200));
}

TEST(Crop, BackgroundMayBePaintedOver) {
  cv::Mat mask = cv::Mat::zeros(30, 40, CV_8U);
  mask({10, 12, 2, 1}).setTo(255);
  mask.at<uchar>(25, 39) = 255;  // no part of the box
  const cv::Rect box(10, 12, 2, 2);
  const cv::Mat gray = cropObject(places(), box, mask, with(Background::gray, 0, 1));
  EXPECT_EQ(gray.at<cv::Vec3b>(0, 1), cv::Vec3b(11, 12, 200));
  EXPECT_EQ(gray.at<cv::Vec3b>(1, 1), kGray);
  const cv::Mat mean = cropObject(places(), box, mask, with(Background::mean, 1, 1));
  ASSERT_EQ(mean.size(), cv::Size(6, 6));
  EXPECT_EQ(mean.at<cv::Vec3b>(2, 3), cv::Vec3b(11, 12, 200));
  EXPECT_NEAR(mean.at<cv::Vec3b>(5, 5)[0], 10.5, 0.51);
  EXPECT_EQ(mean.at<cv::Vec3b>(5, 5)[1], 12);
  const cv::Mat kept = cropObject(places(), box, mask, with(Background::kept, 0, 1));
  EXPECT_EQ(kept.at<cv::Vec3b>(1, 1), cv::Vec3b(11, 13, 200));
}

TEST(Crop, RefusesWhatIsNoObjectInAnImage) {
  const cv::Mat image = places(), mask(30, 40, CV_8U, cv::Scalar(1));
  const auto problem = [&](const cv::Rect& box, const cv::Mat& m = {}, const CropOptions& options = {}) {
    return test::caught([&] { cropObject(image, box, m, options); });
  };
  constexpr int huge = std::numeric_limits<int>::max();
  for (const cv::Rect& box :
       {cv::Rect(0, 0, 0, 5), cv::Rect(-1, 0, 5, 5), cv::Rect(36, 0, 5, 5), cv::Rect(0, 28, 3, 3),
        cv::Rect(huge, 0, 5, 5), cv::Rect(1, 1, huge, huge), cv::Rect(0, 0, -4, 4)})
    EXPECT_THAT(problem(box), FailsWith(ErrorCode::invalidInput)) << box;
  const cv::Rect box(1, 1, 5, 5);
  EXPECT_FALSE(problem(box, mask, with(Background::mean)).code);
  EXPECT_THAT(problem(box, {}, with(Background::mean)), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(problem(box, mask(cv::Rect(0, 0, 20, 20))), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(problem(box, cv::Mat(30, 40, CV_32S, cv::Scalar(1))), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(problem(box, cv::Mat::zeros(30, 40, CV_8U), with(Background::mean)),
              FailsWith(ErrorCode::invalidInput));
  for (const double margin : {-0.1, 4.1, std::nan("")})
    EXPECT_THAT(problem(box, {}, with(Background::kept, margin)), FailsWith(ErrorCode::invalidOption));
  for (const double crop : {0.0, 1.1, std::nan("")})
    EXPECT_THAT(problem(box, {}, with(Background::kept, 0, crop)), FailsWith(ErrorCode::invalidOption));
  const auto crop = [](const cv::Mat& bgr) { cropObject(bgr, {0, 0, 1, 1}); };
  EXPECT_THAT([&] { crop({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { crop(cv::Mat(9, 9, CV_8U)); }, FailsWith(ErrorCode::invalidInput));
  const cv::Mat wide = cv::Mat::zeros(1, 9000, CV_8UC3);
  const cv::Rect all(0, 0, 9000, 1);
  EXPECT_THAT([&] { cropObject(wide, all, {}, with(Background::kept, 4)); }, FailsWith(ErrorCode::tooLarge));
}

/// A board that stands upright and looks along `azimuth`: 24 cm wide, 12 cm high, its upper half red.
PointCloud board(double azimuth, double depth = 0) {
  PointCloud cloud;
  for (int i = -60; i < 60; ++i)
    for (int k = -30; k < 30; ++k) {
      const double along = 0.002 * i, up = 0.002 * k;
      cloud.points.emplace_back(static_cast<float>(-std::sin(azimuth) * along + depth * std::cos(azimuth)),
                                static_cast<float>(std::cos(azimuth) * along + depth * std::sin(azimuth)),
                                static_cast<float>(up));
      cloud.colors.push_back(k < 0 ? cv::Vec3b(0, 255, 0) : cv::Vec3b(0, 0, 255));
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

int pixelsOf(const cv::Mat& image, const cv::Vec3b& color) {
  cv::Mat same;
  cv::inRange(image, color, color, same);
  return cv::countNonZero(same);
}

cv::Rect extentOf(const cv::Mat& image) {
  cv::Mat background;
  cv::inRange(image, kGray, kGray, background);
  return cv::boundingRect(background == 0);
}

TEST(RenderedObject, SeesTheBoardFromItsFaceAndUpright) {
  for (const int degrees : {0, 30, 75, 120, 285}) {
    const cv::Mat image = renderObject(board(degrees * CV_PI / 180), 200);
    ASSERT_EQ(image.size(), cv::Size(200, 200));
    const cv::Rect extent = extentOf(image);
    EXPECT_NEAR(extent.width, 175, 8) << degrees;
    EXPECT_NEAR(extent.height, 87, 8) << degrees;
    EXPECT_EQ(image.at<cv::Vec3b>(80, 100), cv::Vec3b(0, 0, 255)) << degrees;
    EXPECT_EQ(image.at<cv::Vec3b>(120, 100), cv::Vec3b(0, 255, 0)) << degrees;
    const cv::Rect inside(extent.x + 4, extent.y + 4, extent.width - 8, extent.height - 8);
    EXPECT_EQ(pixelsOf(image(inside), kGray), 0) << degrees << ": no holes between the points";
  }
}

TEST(RenderedObject, TheNearestIsInFront) {
  PointCloud near = board(0, 0.05), far = board(0, -0.05);
  near.colors.assign(near.points.size(), {0, 0, 255});
  far.colors.assign(far.points.size(), {255, 0, 0});
  for (auto& p : far.points) p = {p.x, p.y * 0.5F, p.z * 0.5F};  // hidden, seen from the front
  for (const bool nearFirst : {false, true}) {
    PointCloud both = nearFirst ? near : far;
    const PointCloud& second = nearFirst ? far : near;
    both.points.insert(both.points.end(), second.points.begin(), second.points.end());
    both.colors.insert(both.colors.end(), second.colors.begin(), second.colors.end());
    both.width = both.points.size();
    EXPECT_EQ(renderObject(both).at<cv::Vec3b>(149, 149), cv::Vec3b(0, 0, 255)) << nearFirst;
  }
}

TEST(RenderedObject, FewFarAndMissingPoints) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN(), far = 3e38F;
  EXPECT_EQ(extentOf(renderObject(cloudOf({{1, 2, 3}, {none, 0, 0}}), 100)), cv::Rect(48, 48, 5, 5));
  EXPECT_GT(extentOf(renderObject(cloudOf({{-far, 0, 0}, {far, far, -far}}), 100)).width, 50);
  EXPECT_GT(extentOf(renderObject(cloudOf({{0, 0, 0}, {1, 0, 0}}), 100)).width, 70);  // a line has no face
  EXPECT_EQ(extentOf(renderObject(cloudOf({{0, 0, 0}, {1, 0, 0}}), 1)).width, 1);
  const PointCloud hole = cloudOf({{none, 0, 0}}), torn = cloudOf({{1, 2, 3}}, {{1, 2, 3}, {4, 5, 6}});
  EXPECT_THAT([&] { renderObject(hole); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { renderObject({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { renderObject(torn); }, FailsWith(ErrorCode::invalidInput));
  for (const int size : {0, -1, 5000})
    EXPECT_THAT([&] { renderObject(board(0), size); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { renderObject(board(0), 100, with(Background::kept, -1)); },
              FailsWith(ErrorCode::invalidOption));
}

TEST(Cielab, IsOpencvsWithinItsTables) {
  for (int i = 0; i < 4096; ++i) {
    const cv::Vec3b bgr(static_cast<uchar>(17 * (i % 16)), static_cast<uchar>(17 * (i / 16 % 16)),
                        static_cast<uchar>(17 * (i / 256)));
    cv::Mat theirs;
    cv::cvtColor(cv::Mat(1, 1, CV_32FC3, cv::Scalar(bgr[0] / 255.0, bgr[1] / 255.0, bgr[2] / 255.0)), theirs,
                 cv::COLOR_BGR2Lab);
    EXPECT_LT(cv::norm(labOf(bgr) - theirs.at<cv::Vec3f>(0)), 1.5) << bgr;
  }
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(255, 255, 255)) - cv::Vec3f(100, 0, 0)), 0.02);
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(0, 0, 0))), 1e-3);
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(0, 0, 255)) - cv::Vec3f(53.24F, 80.09F, 67.20F)), 0.1);
}

}  // namespace
}  // namespace estancia
