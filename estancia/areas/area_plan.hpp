// Area plan: the floor of a drive, split into areas that are named by what is seen in them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/areas/floor_cells.hpp"
#include "estancia/areas/floor_survey.hpp"
#include "estancia/areas/frame_poses.hpp"
#include "estancia/areas/room_segmentation.hpp"
#include "estancia/core/planar_pose.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/naming_options.hpp"

namespace estancia {

/// A part of the floor that walls and doors enclose.
struct Area {
  /// Its position in AreaPlan::areas. Areas that the robot was in come first, by falling number of frames;
  /// but areas that were known before keep their numbers (keepNumbers()).
  int id = 0;
  /// The words that distinguish what is in it: "refrigerator, stove, microwave".
  std::string name = {};
  /// Free floor space [m²].
  double size = 0;
  /// The point of it that is farthest from its border, on the floor [m].
  cv::Point2d center = {};
  /// Its free space, counter-clockwise on the floor [m].
  std::vector<cv::Point2d> outline = {};
  /// How many frames were taken in it; 0 where the robot only looked in.
  std::size_t frames = 0;
};

struct AreaPlan {
  std::vector<Area> areas;
  /// The map's axes on the floor.
  Floor floor;
  FloorCells cells;
  /// CV_32S: the area of each cell, -1 where nothing is free.
  cv::Mat areaOf;
  /// CV_8U: 255 where walls are.
  cv::Mat walls;
};

/// A correction by a person. It is anchored to the floor [m], so that it outlives another segmentation.
struct AreaEdit {
  enum class Kind {
    /// The area at `from` is called `name`.
    name,
    /// The areas at `from` and `to` are one.
    merge,
    /// The area halfway between `from` and `to` is two, cut along the line between them, which goes on beyond
    /// each end to where the area ends. What is left of it is a new area.
    split
  };
  Kind kind = Kind::name;
  cv::Point2d from = {}, to = {};
  std::string name = {};
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

/// The area that a point of the floor lies in, else the nearest one within `reach` [m]; -1 where there is
/// none.
int areaAt(const AreaPlan& plan, const cv::Point2d& at, double reach);

/// The area that a thing is in, or stands at the edge of: within 2 m. `at`: in the map.
int areaOfObject(const AreaPlan& plan, const cv::Point3d& at);

}  // namespace estancia
