// PCL's stages, beside which ours are measured; in a file of their own, as PCL's headers are slow to compile.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia::test {

/// Rows of SHOTEstimation (352), FPFHEstimation (33), SpinImageEstimation (153) at keypoints.
std::vector<float> pclShot(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius);
/// Rows of SHOTColorEstimation (1344); all points have finite normals.
std::vector<float> pclColorShot(const PointCloud& surface, std::span<const std::uint32_t> keypoints,
                                double radius);
std::vector<float> pclFpfh(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius);
std::vector<float> pclSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints,
                                double radius);

/// The indices that ISSKeypoint3D chooses with the same radii.
std::vector<std::uint32_t> pclIss(const Surface& surface, double radius);
/// The indices that HarrisKeypoint3D chooses without moving its corners.
std::vector<std::uint32_t> pclHarris(const Surface& surface, double radius);

/// Matches of each group of GeometricConsistencyGrouping, after PCL's RANSAC.
std::vector<std::vector<Match>> pclConsistentSets(std::span<const cv::Point3f> model,
                                                  std::span<const cv::Point3f> scene,
                                                  std::span<const Match> matches, double tolerance,
                                                  std::size_t minimum);
/// What PCL's RANSAC, by which PCL's grouping ends, keeps of a set of matches.
std::vector<Match> pclRansac(std::span<const cv::Point3f> model, std::span<const cv::Point3f> scene,
                             std::span<const Match> matches, double tolerance);

}  // namespace estancia::test
