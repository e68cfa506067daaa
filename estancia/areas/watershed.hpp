// Watershed: splits free space where the distance to its border has saddles. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

namespace estancia {

struct Watershed {
  /// CV_32S: the basin of each free cell, -1 elsewhere.
  cv::Mat basins;
  /// The number of cells of each basin.
  std::vector<int> sizes;
  /// For each pair of adjacent basins (lower number first): the distance to the border at the widest point
  /// between them [m].
  std::map<std::pair<int, int>, double> saddles;
};

/// Watershed of the distance to the nearest cell that is 0 in `freeSpace` (CV_8U; outside is 0), from the
/// peaks down. Two basins that meet are one where the saddle is hardly below the lower peak: the wall is only
/// rough there (persistence, Edelsbrunner et al. 2002). `cell`: the width of a cell [m].
Watershed watershedOf(const cv::Mat& freeSpace, const cv::Mat& walls, double cell);

}  // namespace estancia
