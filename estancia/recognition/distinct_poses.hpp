// Non-maximum suppression of poses: the best of each group of similar poses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <opencv2/core/affine.hpp>
#include <utility>
#include <vector>

namespace estancia {

constexpr double anyRotation = -2;  ///< less than any cosine

/// The first `max` of `poses`, best first, each a struct with a T_scene_model called `pose`, without those
/// that are similar to a better one: at the model's `center` less than `minDistance` [m] away, and rotated by
/// less than the angle whose cosine is `minCosine`.
template <class Posed>
std::vector<Posed> distinctPoses(std::vector<Posed> poses, const cv::Point3d& center, double minDistance,
                                 double minCosine,
                                 std::size_t max = std::numeric_limits<std::size_t>::max()) {
  const double minTrace = 1 + 2 * minCosine;
  std::vector<Posed> kept;
  std::vector<cv::Point3d> centers;
  for (Posed& pose : poses) {
    if (kept.size() >= max) break;
    const cv::Point3d at = pose.pose * center;
    bool similar = false;
    for (std::size_t i = 0; i < kept.size() && !similar; ++i) {
      const cv::Point3d d = at - centers[i];
      if (d.dot(d) >= minDistance * minDistance) continue;
      // trace(Aᵀ B) is the sum of the products of their elements
      similar = kept[i].pose.rotation().dot(pose.pose.rotation()) > minTrace;
    }
    if (similar) continue;
    centers.push_back(at);
    kept.push_back(std::move(pose));
  }
  return kept;
}

}  // namespace estancia
