// What lengths suit a scene and a model.
#pragma once

#include "estancia/cloud/mls_surface.hpp"
#include "estancia/recognition/recognition_options.hpp"

namespace estancia {

/// The lengths [m] that a scene is looked at with: those of the options, else what fits the scene.
struct RecognitionScales {
  double normalRadius = 0, keypointSpacing = 0, descriptorRadius = 0, consistency = 0, tolerance = 0;
  // Of mean surfaces, for which they are rounded, so that scenes alike share what models are prepared for:
  double unit = 0;     ///< spacing of the scene's points, within what suits the model's size
  double noise = 0;    ///< standard deviation
  double spacing = 0;  ///< of the scene's points

  bool operator==(const RecognitionScales&) const = default;
};

/// What `options` leave open follows the scene, whose points lie `resolution` [m] from the nearest other and
/// `spacing` apart as on a grid, with so much `noise`. `extent` [m] is that of the model; 0: none yet.
RecognitionScales scalesFor(const RecognitionOptions& options, double resolution, double spacing,
                            double noise, double extent = 0);

/// What a surface is averaged over.
MlsOptions smoothingFor(const RecognitionScales& scales);

}  // namespace estancia
