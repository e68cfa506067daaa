// Clustered frame: a frame with depth, segmented into objects, and images of objects for labelers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct ClusteredFrame {
  /// BGR.
  cv::Mat image;
  /// CV_32F [m]; may have another size than the image.
  cv::Mat depth;
  /// Camera of the depth image.
  CameraIntrinsics camera;
  /// Their points and boxes are pixels of the depth image.
  Clusters clusters;
};

/// Throws Error as findClusters(), and (invalidInput) on an image that is not BGR.
ClusteredFrame clusteredFrame(const cv::Mat& image, const cv::Mat& depth, const CameraIntrinsics& camera,
                              const ClusterOptions& options = {});

/// Throws Error (invalidInput) unless the sequence has depth and its camera is known.
void requireClusterable(const Sequence& sequence);

struct ImageAndDepth {
  cv::Mat image, depth;
};

/// Reads image and depth of frame i in parallel. Throws Error, (mismatch) if they do not show the same view.
ImageAndDepth readImageAndDepth(const Sequence& sequence, std::size_t i);

/// The points of cluster i in the optical frame of the camera, colored by the image; not organized.
PointCloud cloudOf(const ClusteredFrame& frame, std::size_t i);

/// The box of cluster i in the image; where image and depth differ in size, both show the same view.
cv::Rect boxOf(const ClusteredFrame& frame, std::size_t i);

/// Not 0 where the image shows cluster i; CV_8U, the size of the image.
cv::Mat maskOf(const ClusteredFrame& frame, std::size_t i);

/// The image of cluster i for labelers: cropObject() of its box. Throws Error on invalid options.
cv::Mat cropObject(const ClusteredFrame& frame, std::size_t i, const CropOptions& options = {});

/// One frame a view: cropObject() of its image, else renderObject() of its cloud. `views` must outlive it.
std::unique_ptr<Sequence> cropsOf(const ObjectViews& views, const CropOptions& options = {});

}  // namespace estancia
