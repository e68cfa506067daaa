// What lengths suit a scene and a model.
#pragma once

#include "estancia/cloud/mean_surface.hpp"
#include "estancia/recognition/recognizer.hpp"

namespace estancia {

/// What `options` leave open follows the scene, whose points lie `resolution` [m] from the nearest other and
/// `spacing` apart as on a grid, with so much `noise`. `extent` [m] is that of the model; 0: none yet.
RecognitionLengths lengthsFor(const RecognitionOptions& options, double resolution, double spacing,
                              double noise, double extent = 0);

/// What a surface is averaged over.
MeanSurfaceOptions smoothingFor(const RecognitionLengths& lengths);

}  // namespace estancia
