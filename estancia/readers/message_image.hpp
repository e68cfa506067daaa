// Images of ROS messages: raw and compressed images, depth and organized clouds to pixels, in OpenCV's types.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "estancia/core/point_cloud.hpp"
#include "estancia/ros/messages.hpp"

namespace estancia::io {

/// Content of a message of an image topic.
enum class ImageContent {
  color,
  gray,
  /// 16UC1, 32FC1, mono16, compressedDepth: 16 bits may also be the gray of an infrared camera.
  depth,
  /// An encoding that is not supported.
  unknown
};
ImageContent contentOf(const ros::ImageMessage& message);
/// Depth where the cloud is organized as an image.
ImageContent contentOf(const ros::PointCloudMessage& message);
/// Determined by its format, or if that is ambiguous, by the header of the image file.
ImageContent contentOf(const ros::CompressedImageMessage& message);

/// BGR, 8 bits, 3 channels, a copy. Encodings of sensor_msgs/image_encodings: mono, rgb, bgr, rgba, bgra of 8
/// and 16 bits, bayer of 8 and 16 bits, yuv422 and its variants, nv21, nv12, and OpenCV's types of 1, 3 and 4
/// channels. Throws Error: unsupportedFile for others; malformedFile for data of another size; tooLarge.
cv::Mat imageOf(const ros::ImageMessage& message);
/// Throws Error: malformedFile, unsupportedFile, tooLarge.
cv::Mat imageOf(const ros::CompressedImageMessage& message);

/// Meters, CV_32F, 0 where unknown: 16UC1, mono16 (`unitsPerMeter`; 0: mm), 32FC1. Throws as imageOf().
cv::Mat depthOf(const ros::ImageMessage& message, double unitsPerMeter);
/// An image file of 16 bits, or compressedDepth, the transport of ROS: 16 bits as a PNG file or as RVL
/// (Wilson 2017, "Fast Lossless Depth Image Compression") behind a header of 12 bytes: a format, and two
/// numbers a and b that the inverse depth of a float image was quantized with, z = a / (v − b). Throws Error.
cv::Mat depthOf(const ros::CompressedImageMessage& message, double unitsPerMeter);

/// z of an organized cloud [m]. Throws Error as cloudOf().
cv::Mat depthOf(const ros::PointCloudMessage& message);

// By the type of a message: sensor_msgs/Image, CompressedImage, and for depth PointCloud2.

/// `frame` becomes that of its header.
ImageContent contentOf(const ros::SerializedMessage& message, const std::string& type, std::string& frame);
cv::Mat imageOf(const ros::SerializedMessage& message, const std::string& type);
cv::Mat depthOf(const ros::SerializedMessage& message, const std::string& type, double unitsPerMeter);

/// x, y, z [m], and the colors of fields rgb or rgba; organized where the message's height is above 1. Throws
/// Error: unsupportedFile without fields x, y, z; malformedFile; tooLarge.
PointCloud cloudOf(const ros::PointCloudMessage& message);

}  // namespace estancia::io
