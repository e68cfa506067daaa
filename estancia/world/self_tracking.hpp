// Self-tracking: where a map's camera was, by RGB-D odometry while the frames come. Private to WorldMapper.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/odometry/tracker.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/leveling.hpp"
#include "estancia/world/world_mapper.hpp"

namespace estancia {

/// An RgbdTracker whose state is rows of the map, in the transaction of its frames; so tracking goes on after
/// a crash to the last bit as if nothing had happened. The tracker takes the first camera for level; the
/// map's poses are leveled: z is up by the planes that the views have seen.
///
/// Invariant: told_[i] is the leveled pose of frame i that the map has or gets from takeCorrections(), and
/// after save() the rows equal the members. A frame is add(), addPlanes() if it is a view, save(); settle()
/// replaces the tracker's state by the optimum, which the next add() undoes by reading the rows.
class SelfTracking {
 public:
  /// Whether the camera of the map's frames was tracked so.
  static bool isOf(MapStore& store);
  /// Whether such a map is level; those of older programs are not.
  static bool hasLevel(MapStore& store);

  /// Goes on where the map's rows end; the store must outlive it. Throws Error: invalidOption, unknownName;
  /// corruptFile; mismatch for other options or another camera than those of the map.
  SelfTracking(MapStore& store, const CameraIntrinsics& camera, const RgbdOptions& options);

  /// The frame that the map gets next is another drive's.
  void beginDrive();
  /// Tracks the map's next frame: its pose where known already. Image and depth may be empty.
  std::optional<Pose> add(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                          const cv::Mat& depth);
  /// Earlier frames whose poses differ from the map's; each is returned once.
  std::vector<MappingSession::Correction> takeCorrections() { return std::exchange(corrections_, {}); }

  /// Its poses are not leveled.
  const RgbdTracker& tracker() const { return *tracker_; }
  /// The frame's pose in the map, as it was last reported.
  const std::optional<Pose>& pose(std::size_t frame) const { return told_[frame]; }

  /// Planes seen by the latest or an earlier frame.
  void addPlanes(std::size_t frame, std::span<const Plane> planes);
  void dropPlanes(std::size_t frame);
  /// Levels the map by all seen so far, or by the cameras (Floor), and moves the frames, unless within 0.05°.
  void level();
  /// How level() did it the last time.
  const MapLevel& leveled() const { return leveled_; }

  /// The layers were made of views at other poses than those that are known now: they follow from time to
  /// time. To go on with the very layers, the map keeps what they were made with: the direction of up in the
  /// tracker's map, the tracker's revision, and the pose of each view that is in them.
  struct Fold {
    cv::Vec3d up{0, 0, 1};
    std::uint64_t revision = 0;
  };
  const std::optional<Fold>& fold() const { return fold_; }
  /// The pose of a view in the layers; nothing where it is not in them.
  std::optional<Pose> folded(std::size_t frame) const;
  /// The layers are made anew, with the level and the poses of now; their views follow.
  void startFold();
  void addToFold(std::size_t frame);
  /// Whether the layers were made with what is known now.
  bool isFoldCurrent() const { return fold_ && fold_->up == up_ && fold_->revision == tracker_->revision(); }

  /// Writes what has changed; to be called when all of a frame is in the map.
  void save();

  /// Optimizes all poses; takeCorrections() returns the changes. Frames may follow as if it had not.
  RgbdTrajectory settle();

 private:
  void load();
  void compare(std::size_t first, std::size_t end);
  void level(double tolerance);
  void take(const cv::Vec3d& up);
  std::optional<Pose> leveled(const std::optional<Pose>& pose) const;
  std::optional<std::size_t> origin() const;

  MapStore& store_;
  CameraIntrinsics camera_;
  RgbdOptions options_;
  std::optional<RgbdTracker> tracker_;
  bool settled_ = false;  ///< tracker_ is the optimum, not the state of the rows
  std::vector<std::optional<Pose>> told_;
  std::vector<MappingSession::Correction> corrections_;
  Leveling planes_;
  std::set<std::size_t> newPlanes_;  ///< since save()
  cv::Vec3d up_{0, 0, 1};            ///< in the tracker's map
  cv::Affine3d rotation_;            ///< from the tracker's map to the leveled one
  bool newLevel_ = false;            ///< since save()
  MapLevel leveled_;
  std::optional<std::size_t> origin_;  ///< the first frame that is in the map
  std::optional<Fold> fold_;
  std::map<std::size_t, Pose> folded_;  ///< in the tracker's map
  bool foldStarted_ = false;            ///< since save()
  std::set<std::size_t> newlyFolded_;   ///< since save()
};

}  // namespace estancia
