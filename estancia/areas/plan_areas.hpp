// Area planning: splits the free space that a drive has seen into areas, and corrects a plan. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/occupancy_grid.hpp"
#include "estancia/areas/room_segmentation.hpp"
#include "estancia/areas/word_map.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/installed_words.hpp"

namespace estancia {

/// What a drive has seen of the floor so far: free space, walls, and where words are.
struct FloorSurvey {
  OccupancyGrid grid;
  WordMap words;

  /// `cell`: the width of a cell of the grid [m]; `labels`: the number of labels of a descriptor.
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

/// Where the cameras of one or more drives stood.
struct DrivePoses {
  const FramePoses& poses;
  /// The first frames of the drives, in order.
  std::span<const std::size_t> starts = {};
};

/// A plan, and the area of each frame that is not left out.
struct PlannedFrames {
  AreaPlan plan;
  /// Their numbers, in order.
  std::vector<std::size_t> frames;
  /// Frames without a pose are with the last one of their drive that has it; -1 where the drive has none.
  std::vector<int> areaOfFrame;
};

/// Splits the free space of a survey into rooms (segmentRooms()), and names each by the words of what is seen
/// in it, as far as they are more than `mean`, the mean probability of each label in the whole drive.
/// `frames`: where the cameras stood; `edits`: merges and splits, in this order (names are left alone).
/// Throws Error (insufficientData) where no room was seen.
PlannedFrames planAreas(const FloorSurvey& survey, const DrivePoses& frames, const Vocabulary& vocabulary,
                        const std::vector<float>& mean, const RoomSegmentationOptions& options = {},
                        std::span<const AreaEdit> edits = {}, const NamingOptions& naming = {});

/// Applies one more merge or split to a plan. `words`: what planAreas() took them from. Nothing where it
/// would change nothing: one of its ends is in no area, both are in one, or the line leaves a way around it.
std::optional<PlannedFrames> correctPlan(const AreaPlan& plan, const AreaEdit& edit, const DrivePoses& frames,
                                         const WordMap& words, const Vocabulary& vocabulary,
                                         const std::vector<float>& mean, const NamingOptions& naming = {});

/// Renumbers areas that lie where areas of `before` lay as those, as far as numbers have no gaps: by the
/// floor that they share, most first. Does nothing where the two plans have other cells or another floor.
void keepNumbers(PlannedFrames& planned, const AreaPlan& before);

}  // namespace estancia
