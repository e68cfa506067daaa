// Floor survey: what a drive has seen of the floor so far: free space, walls, and where words are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "estancia/areas/occupancy_grid.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

struct FloorSurvey {
  OccupancyGrid grid;
  WordMap words;

  /// `cell`: the width of a cell of the grid [m]; `labels`: the number of labels of a descriptor. Throws
  /// Error (invalidOption).
  FloorSurvey(const Floor& floor, double cell, std::size_t labels)
      : grid(floor, cell), words(floor, labels) {}

  /// Adds a view: depth along the optical axis [m] (CV_32F, 0 where unknown), the camera of the depth image,
  /// and where it stood. Throws Error as OccupancyGrid::add() and WordMap::add().
  void add(DescriptorView descriptor, const cv::Mat& depth, const CameraIntrinsics& camera,
           const Pose& pose) {
    grid.add(depth, camera, pose);
    words.add(descriptor, depth, camera, pose);
  }
};

}  // namespace estancia
