// A frame with depth, taken apart into things.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/io/sequence.hpp"

namespace estancia {

struct ClusteredFrame {
  cv::Mat image;            ///< BGR
  cv::Mat depth;            ///< CV_32F [m]; may have another size than the image
  CameraIntrinsics camera;  ///< of the depth image
  Clusters clusters;        ///< their points and boxes are pixels of the depth image
};

/// Throws Error as findClusters() does, and on an image that is not BGR.
ClusteredFrame clusteredFrame(const cv::Mat& image, const cv::Mat& depth, const CameraIntrinsics& camera,
                              const ClusterOptions& options = {});

/// Throws Error, saying what to do, unless the sequence has depth and its camera is known.
void requireClusterable(const Sequence& sequence);

struct ImageAndDepth {
  cv::Mat image, depth;
};

/// Of frame i, read side by side. Throws Error when either cannot be read, or they cannot show the same view.
ImageAndDepth readImageAndDepth(const Sequence& sequence, std::size_t i);

/// The points of cluster i in the optical frame of the camera, colored by the image; not organized.
PointCloud cloudOf(const ClusteredFrame& frame, std::size_t i);

/// The box of cluster i in the image; where image and depth differ in size, both show the same view.
cv::Rect boxOf(const ClusteredFrame& frame, std::size_t i);

/// Not 0 where the image shows cluster i; CV_8U, the size of the image.
cv::Mat maskOf(const ClusteredFrame& frame, std::size_t i);

/// The image of cluster i for labelers: cropObject() its box. Throws Error on options out of range.
cv::Mat cropObject(const ClusteredFrame& frame, std::size_t i, const CropOptions& options = {});

}  // namespace estancia
