// Areas: the rooms of a drive on a floor plan, found by space and named by words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "estancia/areas/floor_cells.hpp"
#include "estancia/areas/room_segmentation.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/planar_pose.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct AreaOptions {
  double cell = 0.05;
  RoomSegmentationOptions segmentation;
  WordMapOptions words;
};
OptionGroup declare(AreaOptions& options);

/// A part of the floor that walls and doors enclose.
struct Area {
  /// Its position in Areas::areas. Those that the robot was in come first and are the zones of the same id.
  int id = 0;
  /// The words that distinguish what is in it: "refrigerator, stove, microwave".
  std::string name = {};
  /// Of its free space [m²].
  double size = 0;
  /// The point of it that is farthest from its border, on the floor [m].
  cv::Point2d center = {};
  /// Its free space, counter-clockwise on the floor [m].
  std::vector<cv::Point2d> outline = {};
  /// How many frames were taken in it; 0 where the robot only looked in.
  std::size_t frames = 0;
};

struct Areas {
  /// The frames, by the area that the camera stood in. Frames without a pose are with the last one that has
  /// it.
  Zones zones;
  std::vector<Area> areas;
  /// The map's axes on the floor.
  Floor floor;
  FloorCells cells;
  /// CV_32S: the area of each cell, -1 where nothing is free.
  cv::Mat areaOf;
  /// CV_8U: 255 where walls are.
  cv::Mat walls;
  /// Where words are.
  WordMap words;
};

/// Finds the areas of a drive with poses and depth: `labeled` holds frames of `sequence` with their words.
/// Free space is gathered from depth (OccupancyGrid), split into rooms (segmentRooms()), and each room is
/// named by the words of what is seen in it (WordMap). Throws Error: insufficientData unless a frame has a
/// pose, words and depth; invalidOption; tooLarge where the poses span too much; Interrupted.
Areas findAreas(const Sequence& sequence, const DescriptorSequence& labeled, const AreaOptions& options = {},
                Progress& progress = Progress::none());

}  // namespace estancia
