// Default boxes: where in the image the rows of a detector's output look. Private to network labelers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

namespace estancia {

/// The default boxes of the Single Shot MultiBox Detector (Liu et al., ECCV 2016, section 2.2), with the
/// sizes of TensorFlow's detectors: of each grid of n × n cells, row by row, three boxes of the first grid
/// and six of the others, in [0, 1] of the image's width and height, which they may leave.
std::vector<cv::Rect2d> defaultBoxes(std::span<const int> grids);

/// The boxes that look at a region: those that overlap it well (IoU of 0.4 or more), or else nearly as well
/// as the best one does.
std::vector<std::size_t> boxesOf(const cv::Rect2d& region, std::span<const cv::Rect2d> boxes);

}  // namespace estancia
