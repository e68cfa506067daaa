// Poses that say the same, of which one is enough.
#pragma once

#include <cstddef>
#include <limits>
#include <opencv2/core/affine.hpp>
#include <utility>
#include <vector>

namespace estancia {

constexpr double anyTurn = -2;  ///< less than any cosine

/// The first `most` of `poses`, best first, each a struct with a T_scene_model called `pose`, that no better
/// one is like: less than `apart` [m] away at the model's `center` and turned by less than the angle whose
/// cosine is `alike`.
template <class Posed>
std::vector<Posed> differentPoses(std::vector<Posed> poses, const cv::Point3d& center, double apart,
                                  double alike, std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const double leastTrace = 1 + 2 * alike;
  std::vector<Posed> left;
  std::vector<cv::Point3d> centers;
  for (Posed& pose : poses) {
    if (left.size() >= most) break;
    const cv::Point3d at = pose.pose * center;
    bool known = false;
    for (std::size_t i = 0; i < left.size() && !known; ++i) {
      const cv::Point3d d = at - centers[i];
      if (d.dot(d) >= apart * apart) continue;
      // trace(Aᵀ B) is the sum of the products of their elements
      known = left[i].pose.rotation().dot(pose.pose.rotation()) > leastTrace;
    }
    if (known) continue;
    centers.push_back(at);
    left.push_back(std::move(pose));
  }
  return left;
}

}  // namespace estancia
