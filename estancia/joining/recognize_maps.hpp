// Recognizing maps in each other: which places of two map files are one, and how their poses fit. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/joining/merge_maps.hpp"
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

/// Localizes the drives of `b` in `a`, each with up to 4,096 images, evenly thinned, by a Bayes filter that
/// knows what comes next (fixed-lag smoothing).
LocalizedMap localizeMap(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace estancia
