// Areas: the rooms of a drive on a floor plan, found by space and named by words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/room_segmentation.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct AreaOptions {
  double cell = 0.05;
  RoomSegmentationOptions segmentation;
  NamingOptions naming;
};
OptionGroup declare(AreaOptions& options);

/// The plan of a drive with poses and depth, and its frames by area.
struct Areas : AreaPlan {
  /// Frames by the area that the camera stood in, zone i is area i; without a pose as the frame before.
  Zones zones;
  /// Where words are.
  WordMap words;
};

/// Finds the areas of a drive with poses and depth: `labeled` holds frames of `sequence` with their words.
/// Free space is gathered from depth (OccupancyGrid), split into rooms, and named (planAreas()). Throws
/// Error: insufficientData unless a frame has a pose, words and depth; invalidOption; tooLarge; Interrupted.
Areas findAreas(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options = {},
                Progress& progress = Progress::none());

}  // namespace estancia
