// Mutual visibility: which share of the points of two regions see each other. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace estancia {

/// Counts of pairs of sample points that see each other, by their regions.
class VisiblePairs {
 public:
  explicit VisiblePairs(std::size_t regions)
      : regions_(regions), seen_(regions * regions), points_(regions) {}

  void addPoint(std::size_t region) { points_[region] += 1; }
  /// Counts one pair of points, one in each region, in both orders.
  void addPair(std::size_t a, std::size_t b) {
    seen_[a * regions_ + b] += 1;
    seen_[b * regions_ + a] += 1;
  }
  /// The share of pairs with a point in each that see each other; 0 without points.
  double share(std::size_t a, std::size_t b) const {
    const double pairs = a == b ? points_[a] * (points_[a] - 1) : points_[a] * points_[b];
    if (a == b && points_[a] == 1) return 1;
    return pairs > 0 ? seen_[a * regions_ + b] / pairs : 0;
  }
  /// Moves all points of `b` to `a`.
  void merge(std::size_t a, std::size_t b);

 private:
  std::size_t regions_;
  std::vector<double> seen_, points_;
};

/// Sample points of free space (CV_8U, not 0) on a regular grid, those of each region (CV_32S, the same size;
/// < 0: none), which see each other where the straight line between them is free. At most a few thousand
/// points. `cell`: the width of a cell [m].
VisiblePairs countVisible(const cv::Mat& freeSpace, const cv::Mat& regions, std::size_t count, double cell);

}  // namespace estancia
