// Room segmentation: splits free space at doors and narrow passages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "estancia/core/options.hpp"

namespace estancia {

struct RoomSegmentationOptions {
  double mutualVisibility = 0.75;
  /// Smaller pieces belong to the neighbor with the widest opening [m²].
  static constexpr double minArea = 0.5;
};
OptionGroup declare(RoomSegmentationOptions& options);

/// Labels each cell of free space (CV_8U, not 0) with its room: CV_32S of the same size, 0 where nothing is
/// free, rooms 1, 2 … by falling size. `cell`: the width of a cell [m].
///
/// The distance to the nearest wall has a peak in the middle of each room and a saddle in each door; its
/// watershed splits the space exactly at the narrowest cells (the critical lines of Voronoi segmentation:
/// Thrun 1998; Bormann et al. 2016). It also splits a corridor at a cupboard. But where two neighbors see
/// nearly all of each other, what is between them is no door: they are one room.
cv::Mat segmentRooms(const cv::Mat& freeSpace, const cv::Mat& walls, double cell,
                     const RoomSegmentationOptions& options = {});

}  // namespace estancia
