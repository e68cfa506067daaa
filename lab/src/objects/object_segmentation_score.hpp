// Segmentation score: clusters against the objects of an image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia::experiments {

/// The pixels of one object, row by row, ascending.
using PixelSet = std::vector<std::uint32_t>;

/// Score of one image.
struct SegmentationScore {
  std::size_t objects = 0;
  /// Objects with a cluster of intersection over union ≥ 0.5.
  std::size_t found = 0;
  /// Objects of which two clusters or more hold a fifth each.
  std::size_t over = 0;
  /// Objects that share a cluster which holds a fifth of each.
  std::size_t under = 0;
  /// Sum over the objects of that of their best clusters.
  double iou = 0;
};

/// `truth`: CV_32S, the object of each pixel, 0 where there is none. Pixels of clusters that are no object's
/// count against them. Throws Error on another type of image and on pixels that it does not have.
SegmentationScore scoreClusters(const cv::Mat& truth, const std::vector<PixelSet>& clusters);

/// The objects of `truth` where `depth` (CV_32F) is known; 0 elsewhere. Throws Error when their sizes differ.
cv::Mat whereDepthIs(const cv::Mat& truth, const cv::Mat& depth);

/// Pixels of each object of `truth`, by number.
std::vector<PixelSet> objectsOf(const cv::Mat& truth);

/// An object's pixels as a photograph of it would be seen: on the plane through its centroid that faces the
/// camera, with the noise (1.4 mm · z²) and the steps (2.85 mm · z²) of a Kinect's depth (Khoshelham,
/// Oude Elberink, Sensors 12, 2012). `cloud` is that of the image, organized.
PointCloud posterOf(const PointCloud& cloud, const PixelSet& object, std::uint64_t seed);

}  // namespace estancia::experiments
