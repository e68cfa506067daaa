// How objects are looked for: the stages of thesis chapter 2 and their parameters, and known sets of these.
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/cloud/filter.hpp"

namespace estancia {

/// Which stages, and their lengths. A length of 0 follows the scene, its resolution and its noise, so that
/// clouds in other units give the same.
struct RecognitionOptions {
  FilterOptions modelFilter, sceneFilter;
  /// Filtered: the filter's points as they are, plane normals; mean: averaged over the raw points around
  /// them, as noise asks for, and models are given the scene's noise.
  std::string surface = "filtered";
  std::string keypoints = "uniform";               ///< uniform, harris3d, iss
  std::string descriptor = "shot";                 ///< shot, fpfh, spin-image
  std::string grouping = "geometric-consistency";  ///< geometric-consistency, hough, local-frames
  std::string verification = "global";             ///< global, inliers, evidence
  double normalRadius = 0;                         ///< [m] of the points that a normal is fitted to
  /// Of filtered surfaces: nearest points that a normal is fitted to, whatever their distance; 0: the radius
  /// says.
  std::size_t normalNeighbors = 0;
  double keypointSpacing = 0;       ///< [m] between keypoints (uniform), or their support
  double descriptorRadius = 0;      ///< [m] of what a descriptor sees
  double consistency = 0;           ///< [m] up to which matches agree: the bin of Hough voting, too
  double tolerance = 0;             ///< [m] between a model point and the scene point that confirms it
  double sceneKeypointSpacing = 0;  ///< [m] between uniform keypoints of a scene; 0: as in models
  std::string matchEach = "scene";  ///< scene, model: whose keypoints each get their nearest
  std::size_t neighbors = 1;        ///< nearest descriptors that become matches
  double matchDistance = 0;         ///< the largest between them, in lengths of the scene's; 0: any
  std::size_t minimalMatches = 3;   ///< that must agree
  std::size_t hypotheses = 100;     ///< with most matches that are refined and verified
  double accept = 0.6;  ///< share of what should be seen of a model that must be; or the least evidence
  /// Where the scene's sensor stood [m], in the scene's frame; none: where the cloud says; else at its
  /// origin, looking along z.
  std::optional<cv::Point3d> viewpoint;
  int threads = 0;  ///< 0: one a usable core

  /// Throws Error on unknown stages, naming the known ones, and on lengths and numbers that make no sense.
  void check() const;

  /// The known sets, each with one line of explanation: default, classical, thesis, tight, wide.
  static std::vector<std::pair<std::string, std::string>> presets();
  /// One of them. Throws Error on others, naming the known ones.
  static RecognitionOptions preset(const std::string& name);
};

}  // namespace estancia
