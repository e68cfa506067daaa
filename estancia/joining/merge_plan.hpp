// Merge plan: the order in which maps become one, where their poses go, which places are one. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/joining/map_source.hpp"
#include "estancia/joining/recognize_maps.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

struct MergePlan {
  /// Numbers of maps: each is linked with one before it, if with any.
  std::vector<std::size_t> order;
  /// From the map to the merged one, where that is known; by number.
  std::vector<std::optional<cv::Affine3d>> toMerged;
  /// Offset of the ids of each map's places; by number.
  std::vector<int> firstNode;
  /// Places that became parts of others, in order; their frames are to be set.
  std::vector<Merge> merges;

  /// The place that one became a part of, or itself; by new ids.
  int kept(int node) const;
  std::map<int, int> keptBy;
};

/// Maps whose links by words are few, or whose poses are to be found, are also compared image by image, each
/// with the one before it that it shares most places with. Links that poses contradict are left out, and so
/// is the worse one of two by which two places of one map would be one.
MergePlan planMerge(std::span<const std::unique_ptr<MapSource>> sources, std::vector<LinkedMaps> linked,
                    Progress& progress);

}  // namespace estancia
