// Descriptor matching: exact k nearest neighbors by matrix products (thesis 2.4.4).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// A keypoint of a model and one of a scene with similar descriptors.
struct Match {
  std::uint32_t model = 0, scene = 0;  ///< indices of the described keypoints
  float squared = 0;                   ///< squared distance of the descriptors

  bool operator==(const Match&) const = default;
};

struct NearRow {
  std::uint32_t other = 0;
  float squared = 0;
};
/// For each of `rows` the `count` rows of `others` nearest by Euclidean distance, nearest first; ties are
/// broken by the lower row. The result does not depend on the number of threads. Throws Error when their
/// lengths differ.
std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads = 1);

/// Whose keypoints are each matched.
enum class MatchEach {
  /// Each scene keypoint with the nearest model keypoints: clutter gets matches, too.
  scene,
  /// Each model keypoint with the nearest scene keypoints: far fewer matches, several of which can be right.
  model
};

/// The matches of each keypoint of one side with its `count` nearest of the other, nearest descriptors first;
/// with a `distance`, only those within this share of the norm of the scene's descriptor.
std::vector<Match> matchDescriptors(const DescriptorMatrix& model, const DescriptorMatrix& scene,
                                    MatchEach each, std::size_t count, double distance = 0, int threads = 1);

}  // namespace estancia
