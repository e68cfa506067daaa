// Samples and pairs of segments stay below their limits.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segment_samples.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <set>

#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

using ::testing::UnorderedElementsAre;

const CameraIntrinsics kKinect{640, 480, 525, 525, 319.5, 239.5};

/// Tiles of 12 pixels, each at another depth than those around it: some 1,800 segments.
cv::Mat tiles(float nearest) {
  cv::Mat depth(480, 640, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const int column = u / 12, row = v / 12;
      depth.at<float>(v, u) = nearest * (1 + 0.02F * static_cast<float>((5 * column + 3 * row) % 13));
    }
  return depth;
}

/// A segment as large as a point.
SegmentSamples dot(std::uint32_t piece, const cv::Point3f& at) {
  return {.segment = piece, .surface = {at}, .border = {at}, .box = {at, at}, .x = {}, .y = {}, .z = {}};
}

TEST(Shapes, TheLargestOfManyPieces) {
  for (const float nearest : {0.02F, 0.6F}) {
    const ClusterOptions options;
    const InverseDepth grid = inverseDepth(tiles(nearest), kKinect, 1);
    const PlaneRemoval scene = removePlanes(grid, options);
    const Segmentation segments =
        oversegment(grid, scene.rest, concaveCreases(grid, scene.rest, options.creaseDepth, options.threads));
    ASSERT_GT(segments.sizes.size(), 3 * kMaxSegmentSamples);
    const std::vector<SegmentSamples> samples = sampleSegments(grid, scene.rest, segments);
    ASSERT_EQ(samples.size(), kMaxSegmentSamples);
    EXPECT_TRUE(std::ranges::is_sorted(samples, {}, &SegmentSamples::segment));
    std::set<std::uint32_t> taken;
    std::uint32_t smallest = segments.sizes[samples.front().segment], largestLeft = 0;
    for (const SegmentSamples& sample : samples) {
      taken.insert(sample.segment);
      smallest = std::min(smallest, segments.sizes[sample.segment]);
      EXPECT_FALSE(sample.surface.empty() || sample.border.empty());
    }
    ASSERT_EQ(taken.size(), kMaxSegmentSamples);
    for (std::uint32_t i = 1; i < segments.sizes.size(); ++i)
      if (!taken.contains(i)) largestLeft = std::max(largestLeft, segments.sizes[i]);
    EXPECT_GE(smallest, largestLeft);
    EXPECT_EQ(nearPairs(samples, segments, 0.2).size(), kMaxPairs) << nearest;  // of tens of thousands
  }
}

TEST(Shapes, NearPairsThatDoNotTouch) {
  const std::vector<SegmentSamples> samples{dot(1, {0, 0, 1}), dot(3, {0.1F, 0, 1}), dot(4, {0.25F, 0, 1}),
                                            dot(7, {0.25F, 0, 3})};
  Segmentation segments;
  EXPECT_THAT(nearPairs(samples, segments, 0.2), UnorderedElementsAre(std::pair(0U, 1U), std::pair(1U, 2U)));
  segments.touching = {{1, 3}};
  EXPECT_THAT(nearPairs(samples, segments, 0.2), UnorderedElementsAre(std::pair(1U, 2U)));
}

TEST(Shapes, TheNearestOfManyPairs) {
  std::vector<SegmentSamples> samples;
  for (std::uint32_t i = 0; i < kMaxSegmentSamples; ++i)
    samples.push_back(dot(i + 1, {static_cast<float>(i * i) * 1e-7F, 0, 1}));
  const auto apart = [&](std::size_t i, std::size_t j) {
    return std::abs(samples[i].box.low.x - samples[j].box.low.x);
  };
  const auto chosen = nearPairs(samples, {}, 0.2);
  const std::set pairs(chosen.begin(), chosen.end());
  ASSERT_EQ(pairs.size(), kMaxPairs);
  float farthest = 0, nearestLeft = 1;
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    for (std::uint32_t j = i + 1; j < samples.size(); ++j) {
      if (pairs.contains({i, j}))
        farthest = std::max(farthest, apart(i, j));
      else
        nearestLeft = std::min(nearestLeft, apart(i, j));
    }
  EXPECT_LE(farthest, nearestLeft);
}

TEST(Shapes, CrowdedImagesAreTheSameOnAnyThreads) {
  const cv::Mat depth = tiles(0.6F);
  ClusterOptions options;
  options.minPoints = 1;
  options.threads = 1;
  const Clusters one = findClusters(depth, kKinect, options);
  std::size_t points = 0;
  for (const Cluster& cluster : one.clusters) points += cluster.points.size();
  EXPECT_TRUE(one.planes.empty());
  EXPECT_GT(points, depth.total() / 2);  // tiles that are behind all around them are no things
  options.threads = 3;
  const Clusters three = findClusters(depth, kKinect, options);
  ASSERT_EQ(one.clusters.size(), three.clusters.size());
  for (std::size_t i = 0; i < one.clusters.size(); ++i)
    EXPECT_EQ(one.clusters[i].points, three.clusters[i].points);
}

}  // namespace
}  // namespace estancia
