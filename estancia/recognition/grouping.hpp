// Correspondence grouping: poses on which several matches agree (thesis 2.4.5).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/recognition/descriptors.hpp"

namespace estancia {

/// A pose that some matches support.
struct Hypothesis {
  cv::Affine3d pose;           ///< T_scene_model
  std::vector<Match> matches;  ///< its inliers
};

/// The methods by name: geometric-consistency, hough.
Choices groupingMethods();

/// The poses on which at least `minimum` matches agree within `tolerance` [m], most matches first. Throws
/// Error (unknownName, invalidOption) on an unknown method and on a tolerance that is not positive.
std::vector<Hypothesis> groupMatches(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                     const std::vector<Match>& matches, const std::string& method,
                                     double tolerance, std::size_t minimum, int threads = 1);

// ---- steps of it: sets of matches, and their poses

/// Geometric consistency (Chen and Bhanu 2007): each match, nearest descriptors first, collects all matches
/// that preserve their distances to those collected before within `tolerance` [m]; sets of at least `minimum`
/// are kept, and their matches are used up. `matches` must be sorted. Equals the sets of PCL's
/// GeometricConsistencyGrouping before its RANSAC. O(n²), mostly one vectorized comparison a pair.
std::vector<std::vector<std::uint32_t>> consistentSets(std::span<const cv::Point3f> model,
                                                       std::span<const cv::Point3f> scene,
                                                       std::span<const Match> matches, double tolerance,
                                                       std::size_t minimum, int threads = 1);

/// RANSAC for the rigid transform that brings most points of `from` within `tolerance` [m] of their partners
/// in `to`: samples of three (seeded), refined by least squares on the inliers, whose indices are returned;
/// none when fewer than three agree.
std::pair<cv::Affine3d, std::vector<std::uint32_t>> agreedTransform(std::span<const cv::Point3f> from,
                                                                    std::span<const cv::Point3f> to,
                                                                    double tolerance);

}  // namespace estancia
