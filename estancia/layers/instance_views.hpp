// Instance views: the segments that show an instance best. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "estancia/areas/frame_poses.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// How well a segment shows its thing: the pixels of its box; less where the image cuts it.
double viewQuality(const Observation::Segment& segment);

/// A segment that shows an instance.
struct InstanceView {
  SegmentPlace place;
  /// viewQuality()
  double quality = 0;
};

/// The best views of each instance, `most` at most: `wanted` ones, of frames whose pose is known.
std::vector<std::vector<InstanceView>> bestViews(
    const WorldStore& observations, std::span<const ObjectInstance> instances, const FramePoses& poses,
    std::size_t most, const std::function<bool(std::size_t instance, const Observation::Segment&)>& wanted);

}  // namespace estancia
