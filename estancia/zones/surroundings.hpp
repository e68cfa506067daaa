// Surroundings: descriptors of a run, pooled over images near in space or, without poses, time. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "estancia/core/progress.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct Surroundings {
  /// N×L: of each image the weighted mean of the descriptors around it, its own included, as Eq. 4.3 is of a
  /// place. What the robot sees in one direction is so joined to what it sees in the others.
  DescriptorMatrix descriptors;
  /// How many other images an image is pooled with: mean over the images of the sum of their weights.
  double others = 0;
};

/// Weights fall as a Gaussian, with a standard deviation of options.reach [m] of the distance between two
/// poses. Where one of them has no pose, or all poses are nearer to each other than that, it falls with the
/// way through the images between the two: the sum of the distances of neighbors in time, in units of the
/// distance of images that have nothing to do with each other. O(N² + N L ‧ images around one). Throws Error
/// (unknownName) for the distance; Interrupted.
Surroundings poolSurroundings(const DescriptorSequence& sequence, const ZoneOptions& options,
                              Progress& progress = Progress::none());

}  // namespace estancia
