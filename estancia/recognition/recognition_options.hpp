// Recognition options: the stages of the object recognition pipeline, their parameters, and presets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/options.hpp"

namespace estancia {

/// The stages of thesis chapter 2 by name, and their lengths. A length of 0 follows the scene, its resolution
/// and its noise, so that clouds in other units give the same result. The defaults are the preset "default".
struct RecognitionOptions {
  FilterOptions modelFilter;
  /// The neurons of a neural gas are only seeds of the mean surface, which need few signals.
  FilterOptions sceneFilter{.gng = {.signalsPerInsertion = 25}};
  std::string surface = "mean";
  std::string keypoints = "uniform";
  std::string descriptor = "shot";
  std::string grouping = "local-frames";
  std::string verification = "evidence";
  double normalRadius = 0;
  std::size_t normalNeighbors = 0;
  double keypointSpacing = 0;
  double descriptorRadius = 0;
  double consistency = 0;
  double tolerance = 0;
  /// Units of CIELAB, lightness counts half; 0: colors do not count.
  double colorTolerance = 0;
  double sceneKeypointSpacing = 0;
  std::string matchEach = "model";
  std::size_t neighbors = 30;
  double matchDistance = 0;
  std::size_t minMatches = 3;
  std::size_t maxHypotheses = 300;
  double accept = 0.6;
  double falseAlarmRate = 0.01;
  /// Position of the scene's sensor [m], in the scene's frame; not set: that of the cloud, else the origin,
  /// looking along z.
  std::optional<cv::Point3d> viewpoint;
  /// The scene is no view of one sensor, whatever its viewpoint, as of several views joined.
  bool noView = false;
  int threads = 0;

  /// default, classical, thesis, author-2014, tight, wide.
  static Choices presets();
  /// Throws Error (unknownName).
  static RecognitionOptions preset(const std::string& name);
};
/// Declares the options, their units and their ranges.
OptionGroup declare(RecognitionOptions& options);
/// Throws Error (invalidOption, unknownName) on unknown stages, on numbers out of range, and on normals by
/// both radius and number of neighbors.
void validate(const RecognitionOptions& options);

}  // namespace estancia
