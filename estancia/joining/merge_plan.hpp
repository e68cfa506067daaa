// Merge plan: the places that several maps have in common, and how these maps become one. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/joining/map_source.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/mapper/mapper_merge.hpp"

namespace estancia {

/// Two maps, by their numbers, first < second, and the places that link them: a in the first one.
struct LinkedMaps {
  std::size_t first = 0, second = 0;
  std::vector<PlaceLink> links;

  std::size_t sure() const;
};

/// Compares the places of all pairs of maps by their words; those that have links, in order. Work is shared
/// in pieces of up to 100 pairs; who only helps gets none. Throws Error (busy) where a map has another number
/// of frames than framesOf() returned.
std::vector<LinkedMaps> linkMaps(std::span<const std::filesystem::path> maps, const ShareWork& share,
                                 const std::function<std::size_t(std::size_t)>& framesOf);

/// A map as it was found in another one, image by image.
struct LocalizedMap {
  /// Most images of place b were taken in place a.
  std::vector<PlaceLink> links;
  /// T_a_b, from the views that were recognized; where both maps have depth, that confirms it.
  std::optional<cv::Affine3d> alignment;
};

/// Localizes up to 4,096 images of `b`, evenly thinned, in `a`, by a Bayes filter with fixed-lag smoothing.
LocalizedMap localizeMap(const std::filesystem::path& a, const std::filesystem::path& b);

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
