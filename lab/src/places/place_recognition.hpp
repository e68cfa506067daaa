// Place recognition: does the most similar image show the same place?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/distances/distance.hpp"
#include "places/spatial_variance.hpp"

namespace estancia::experiments {

/// Images by their vectors (comparedVectors()), positions and numbers in their sequence.
struct PlacedImages {
  const DescriptorMatrix& vectors;
  std::span<const Position> positions;
  std::span<const std::size_t> frames;
};

struct PlaceRecognition {
  /// Images whose place is seen in another image, too.
  std::size_t queries = 0;
  /// Share of them whose nearest image lies within the radius; 0 without queries.
  double right = 0;
  /// Value for an image drawn by chance.
  double chance = 0;
};

/// Finds for each query the nearest of `images` by `comparison`. It is right within `radius` [m]. Queries
/// that have no image within the radius do not count. With `gap` > 0 queries and images are one drive, and
/// images taken at most so many frames before or after the query are no answers. O(queries · images ·
/// labels).
PlaceRecognition recognizePlaces(const PlacedImages& queries, const PlacedImages& images,
                                 Comparison comparison, double radius, std::size_t gap);

}  // namespace estancia::experiments
