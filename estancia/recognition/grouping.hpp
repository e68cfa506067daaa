// Matches that agree on where a model is (thesis 2.4.5).
#pragma once

#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/matching.hpp"

namespace estancia {

/// A pose that some matches support.
struct Hypothesis {
  cv::Affine3d pose;           ///< T_scene_model
  std::vector<Match> matches;  ///< that the pose brings together
};

/// The ways to group by name, each with one line of explanation: geometric-consistency, hough.
std::vector<std::pair<std::string, std::string>> groupingMethods();

/// The poses that at least `minimum` matches agree on up to `tolerance` [m], most matches first. Throws Error
/// on an unknown method, naming the known ones, and on a tolerance that is not positive.
std::vector<Hypothesis> groupMatches(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                     const std::vector<Match>& matches, const std::string& method,
                                     double tolerance, std::size_t minimum, int threads = 1);

// ---- each for itself: sets of matches

/// Geometric consistency (Chen and Bhanu 2007): each match, nearest descriptors first, gathers all that keep
/// their distance to every one gathered so far up to `tolerance` [m]; sets of at least `minimum` are kept and
/// their matches taken. `matches` must be sorted. The sets of PCL's GeometricConsistencyGrouping before its
/// RANSAC. O(n²) at most, and mostly one comparison of vectors a pair.
std::vector<std::vector<std::uint32_t>> consistentSets(std::span<const cv::Point3f> model,
                                                       std::span<const cv::Point3f> scene,
                                                       std::span<const Match> matches, double tolerance,
                                                       std::size_t minimum, int threads = 1);

/// 3-D Hough voting (Tombari and Di Stefano 2010): each match says, by the local frames of its two keypoints,
/// where the middle of the model is; sets are votes within `tolerance` [m] of one that has most around it.
std::vector<std::vector<std::uint32_t>> houghSets(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                                  std::span<const Match> matches, double tolerance,
                                                  std::size_t minimum, int threads = 1);

/// The rigid transform that brings most points of `from` within `tolerance` [m] of those of `to`, pair by
/// pair: of samples of three (seeded), refined by least squares on its inliers, whose indices it returns;
/// none when fewer than three agree.
std::pair<cv::Affine3d, std::vector<std::uint32_t>> agreedTransform(std::span<const cv::Point3f> from,
                                                                    std::span<const cv::Point3f> to,
                                                                    double tolerance);

}  // namespace estancia
