// Local features: keypoints of an image with their descriptors, by ORB or SIFT.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>

namespace estancia::experiments {

enum class LocalFeature {
  /// Rublee et al. 2011: 256 bits, here values of 0 and 1, whose squared Euclidean distance is Hamming's.
  orb,
  /// Lowe 2004: 128 values, here the roots of their shares, whose Euclidean distance is Hellinger's
  /// (RootSIFT;
  /// Arandjelović and Zisserman 2012).
  sift
};

/// How many values describe a keypoint.
std::size_t dimensionsOf(LocalFeature feature);

/// The 500 strongest keypoints (ORB's default) at most, one a row, CV_32F; no rows where an image has no
/// corners. `image` is BGR, 8 bits. The result does not depend on the number of threads. Throws Error
/// (invalidInput) on other images.
cv::Mat localFeatures(LocalFeature feature, const cv::Mat& image);

}  // namespace estancia::experiments
