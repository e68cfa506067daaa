// Recognition scales: the lengths of all stages for a scene and a model.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/cloud/mls_surface.hpp"
#include "estancia/recognition/recognition_options.hpp"

namespace estancia {

/// The lengths [m] of the stages: those of the options, else those that fit the scene.
struct RecognitionScales {
  double normalRadius = 0, keypointSpacing = 0, descriptorRadius = 0, consistency = 0, tolerance = 0;
  double color = 0;  ///< color scale of the options
  // Measured on mean surfaces and rounded, so that similar scenes share prepared models:
  double unit = 0;     ///< spacing of the scene's points, limited by the model's size
  double noise = 0;    ///< standard deviation
  double spacing = 0;  ///< spacing of the scene's points

  bool operator==(const RecognitionScales&) const = default;
};

/// Lengths that are 0 in `options` follow the scene: its resolutionOf(), spacingOf() and estimateNoise() [m].
/// `extent` [m] is that of the model; 0: none yet.
RecognitionScales scalesFor(const RecognitionOptions& options, double resolution, double spacing,
                            double noise, double extent = 0);

/// The parameters of moving least squares.
MlsOptions smoothingFor(const RecognitionScales& scales);

}  // namespace estancia
