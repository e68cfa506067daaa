// Merge plan: what map files keep of their drives, the places that they have in common, how they become one.
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
#include "estancia/joining/merge_maps.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/mapper/mapper_merge.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// Snapshot of a map. Frames are identified by their position in map.frames.
struct MapSource {
  /// Throws Error as readMap(); insufficientData for a map without frames, corruptFile without places.
  explicit MapSource(const std::filesystem::path& file);

  std::optional<Pose> givenPose(std::size_t frame) const { return store.givenPose(map.frames[frame].number); }
  LexicalDescriptor descriptor(std::size_t frame) const { return store.descriptor(map.frames[frame].number); }
  std::vector<unsigned char> image(std::size_t frame) const { return store.image(map.frames[frame].number); }
  std::optional<Observation> observation(std::size_t frame) const;
  std::vector<std::size_t> numbers(std::size_t first, std::size_t end) const;
  /// T_map_drive of a drive that is aligned.
  cv::Affine3d alignment(std::size_t drive) const;
  std::size_t end(std::size_t drive) const;
  /// Whether a frame has a pose in the map.
  bool hasPoses() const;

  std::filesystem::path path;
  mutable MapStore store;  ///< reading its tables needs the connection
  TopologicalMap map;
  std::optional<WorldStore> layers;
  std::vector<bool> isObserved;
};

/// Throws Error: mismatch for other vocabularies, models or distances, invalidInput for a drive in common.
void requireMergeable(const MapSource& first, const MapSource& other);

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
