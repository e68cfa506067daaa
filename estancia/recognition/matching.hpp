// Which described places look alike (thesis 2.4.4), exactly, by matrix products.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// A keypoint of a model and one of a scene whose descriptors are near.
struct Match {
  std::uint32_t model = 0, scene = 0;  ///< which described keypoint of each
  float squared = 0;                   ///< of the distance of the descriptors

  bool operator==(const Match&) const = default;
};

/// The `count` rows of `others` nearest to each of `rows` by Euclidean distance, nearest first; of equally
/// near ones the first. `found` says for each row what it got: {row, other, squared}. The same for any number
/// of threads. Throws Error when the rows are not equally long.
struct NearRow {
  std::uint32_t other = 0;
  float squared = 0;
};
std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads = 1);

/// From which side matches are looked for.
enum class MatchEach {
  /// Each scene keypoint gets the model keypoints nearest to it: many scenes' clutter finds a partner.
  scene,
  model  ///< each model keypoint gets the scene keypoints nearest to it: far fewer, and several can be right
};

/// The matches of each keypoint of one side with its `count` nearest of the other, nearest descriptors first;
/// with a `distance`, only those that differ by no more than so many lengths of the scene's descriptor.
std::vector<Match> matchDescriptors(const DescriptorMatrix& model, const DescriptorMatrix& scene,
                                    MatchEach each, std::size_t count, double distance = 0, int threads = 1);

}  // namespace estancia
