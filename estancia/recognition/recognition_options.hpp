// Recognition options: the stages of the object recognition pipeline, their parameters, and presets.
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/choice.hpp"
#include "estancia/core/options.hpp"

namespace estancia {

/// The stages of thesis chapter 2 by name, and their lengths. A length of 0 follows the scene, its resolution
/// and its noise, so that clouds in other units give the same result. The defaults are the preset "default".
struct RecognitionOptions {
  FilterOptions modelFilter;
  /// The neurons of a neural gas are only seeds of the mean surface, which need few signals.
  FilterOptions sceneFilter{.gng = {.signalsPerInsertion = 25}};
  /// "filtered": the points of the filter with plane normals; "mean": moving least squares over the raw
  /// points around them, as wide as the noise requires, with the scene's noise added to models.
  std::string surface = "mean";
  /// Detector: uniform, harris3d, iss.
  std::string keypoints = "uniform";
  /// shot, fpfh, spin-image.
  std::string descriptor = "shot";
  /// geometric-consistency, hough, local-frames.
  std::string grouping = "local-frames";
  /// global, inliers, evidence.
  std::string verification = "evidence";
  /// Of the points that a normal is fitted to [m].
  double normalRadius = 0;
  /// Of filtered surfaces: nearest points that a normal is fitted to, at any distance; 0: by radius.
  std::size_t normalNeighbors = 0;
  /// Distance of uniform keypoints, or the support radius of a detector [m].
  double keypointSpacing = 0;
  /// Support radius of a descriptor [m].
  double descriptorRadius = 0;
  /// Tolerance within which matches agree, and bin size of Hough voting [m].
  double consistency = 0;
  /// Distance between a model point and the scene point that supports it [m].
  double tolerance = 0;
  /// Distance of uniform keypoints of a scene [m]; 0: as in models.
  double sceneKeypointSpacing = 0;
  /// "scene" or "model": whose keypoints are each matched with their nearest of the other.
  std::string matchEach = "model";
  /// Matches of each keypoint.
  std::size_t neighbors = 30;
  /// Largest distance of matching descriptors, as a share of the norm of the scene's; 0: any.
  double matchDistance = 0;
  /// Matches that must agree on a pose.
  std::size_t minMatches = 3;
  /// Poses that are refined and verified, those with most matches.
  std::size_t maxHypotheses = 300;
  /// Smallest evidence; for other verifications the smallest supported share of the visible model.
  double accept = 0.23;
  /// Position of the scene's sensor [m], in the scene's frame; not set: that of the cloud, else the origin,
  /// looking along z.
  std::optional<cv::Point3d> viewpoint;
  /// 0: one a usable core. The result does not depend on it.
  int threads = 0;

  /// default, classical, thesis, tight, wide.
  static Choices presets();
  /// Throws Error (unknownName).
  static RecognitionOptions preset(const std::string& name);
};
OptionGroup declare(RecognitionOptions& options);
/// Throws Error (invalidOption, unknownName) on unknown stages, on numbers out of range, and on normals by
/// both radius and number of neighbors.
void validate(const RecognitionOptions& options);

}  // namespace estancia
