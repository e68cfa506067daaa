// Mapping session implementation: a map file, its mapper, and what labels images. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <exception>

#include <functional>
#include <limits>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>

#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/drive_alignment.hpp"
#include "estancia/session/drive_guide.hpp"
#include "estancia/session/frame_keeper.hpp"
#include "estancia/session/session.hpp"

namespace estancia {

/// The state that FrameKeeper::state() is kept as.
constexpr const char* frameSampleKey = "frame-sample";
/// The state that DriveGuide::known() is kept as; empty where it guides no longer.
constexpr const char* guideMapKey = "guide-map";

/// A map file and its mapper. Invariant: after write() the file holds all that resuming needs, as of the last
/// frame; what has changed since is in memory only, for about a second. `guide` exists while a further drive
/// is guided, `alignment` until its poses are registered to the map, `keeper` if the file has a budget.
struct MappingSession::Impl {
  MapStore store;
  Mapper mapper;
  Labeler* labeler = nullptr;
  std::chrono::steady_clock::time_point lastWritten = std::chrono::steady_clock::now();
  /// In flight when the session began.
  int exceptions = std::uncaught_exceptions();
  bool finished = true;
  /// The last drive of the map.
  Drive drive = {};
  /// Drive guide of further drives.
  std::optional<DriveGuide> guide = {};
  std::size_t guided = 0;  ///< frames of the drive that the guide was certain of
  /// Alignment of a drive that has not been registered to the map by depth.
  std::optional<DriveAlignment> alignment = {};
  std::size_t nextAlignment = 0;  ///< number of pairs at which align() tries again
  std::size_t alignments = 0;     ///< alignments found in this session
  /// Verifies `guess` (T_map_drive) by depth: returns the exact transform near it, or nothing.
  using Verify = std::function<std::optional<cv::Affine3d>(const cv::Affine3d& guess)>;
  /// Owned by the WorldMapper, and gone with it; without one, words decide.
  std::weak_ptr<const Verify> verify = {};

  MapBudget budget = {};
  /// Exists if the file has a budget.
  std::optional<FrameKeeper> keeper = {};

  /// Once, before frames follow.
  void setBudget(const MapBudget& wanted);
  /// Max number of frames of the drive guide; a share of the budget.
  std::size_t maxGuideFrames() const;
  /// Frames that the map must keep to go on, in order.
  std::vector<std::size_t> neededFrames();
  /// Puts waiting frames that are needed into the file, and leaves the others out.
  void settleWaiting(const std::vector<std::size_t>& needed);
  void keep(const MappedFrame& frame, DescriptorView descriptor, const std::optional<Pose>& given);

  /// `isLost`: where it begins is to be found out.
  void beginDrive(const DriveStart& start, bool isLost = true);
  /// Maps a drive that was recognized nowhere again, as if it were the first: by its own scale it has places
  /// that look alike by that of the map. Keeps them apart.
  void mapAlone(std::size_t end = std::numeric_limits<std::size_t>::max());
  void comeBack(std::size_t frame);
  /// Goes on with the last drive of the file.
  void restoreDrive();
  /// A pose that add() was given, in the map.
  std::optional<Pose> inMap(const std::optional<Pose>& given) const;
  void align();
  /// Where the drive is in the map is looked for no longer.
  void endAlignment();
  void endGuidance();

  /// Without writing.
  int add(const Frame& frame, DescriptorView descriptor, const Image& image);
  /// A frame that another map file has: its place and why are known. `jpeg`: may be empty.
  void replay(const Frame& frame, DescriptorView descriptor, const std::vector<unsigned char>& jpeg,
              Decision known);
  /// Whether the file keeps it at once.
  bool take(const MappedFrame& frame, DescriptorView descriptor, const std::optional<Pose>& given);
  void correct(const std::vector<Correction>& corrections);
  void writeWhenDue();
  /// Writes what has changed since the last call.
  void write();
  const MapStore& written();
};

/// Leaves out frames of a map at rest until it has at most so many megabytes; commits. Without a number its
/// own budget counts, if it has one. Throws Error (tooLarge).
void fitFile(MapStore& store, const std::optional<std::uint64_t>& megabytes = {});

constexpr std::uint64_t megabyte = 1'000'000;

/// Budget stored in a map file.
MapBudget budgetOf(const MapStore& store);

}  // namespace estancia
