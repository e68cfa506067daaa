// Self-tracking: where a map's camera was, by RGB-D odometry while the frames come. Private to WorldMapper.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/odometry/tracker.hpp"
#include "estancia/topology/session.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

/// An RgbdTracker whose state is rows of the map, in the transaction of its frames; so tracking goes on after
/// a crash to the last bit as if nothing had happened.
class SelfTracking {
 public:
  /// Whether the camera of the map's frames was tracked so.
  static bool isOf(MapStore& store);

  /// Goes on where the map's rows end; the store must outlive it. Throws Error: invalidOption, unknownName;
  /// corruptFile; mismatch for other options or another camera than those of the map.
  SelfTracking(MapStore& store, const CameraIntrinsics& camera, const RgbdOptions& options);

  /// Tracks the frame that the map gets next, and returns its pose where it is known already. Image and depth
  /// may be empty. The words are those of `descriptor`.
  std::optional<Pose> add(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                          const cv::Mat& depth);
  /// Earlier frames that are elsewhere than the map says; told once.
  std::vector<MappingSession::Correction> takeCorrections();

  const RgbdTracker& tracker() const { return *tracker_; }

  /// The layers were made of views at other poses than those that are known now: they follow from time to
  /// time. To go on with the very layers, the map keeps what they were made with: the direction of up, the
  /// tracker's revision, and the pose of each view that is in them.
  struct Fold {
    cv::Vec3d up{0, 0, 1};
    std::uint64_t revision = 0;
  };
  const std::optional<Fold>& fold() const { return fold_; }
  const std::map<std::size_t, Pose>& folded() const { return folded_; }
  /// The layers are made anew; their views follow.
  void startFold(const Fold& fold);
  void addToFold(std::size_t frame, const Pose& pose);

  /// Writes what has changed; to be called when all of a frame is in the map.
  void save();

  /// The frames where they were by all that was seen. takeCorrections() tells; after it frames may follow as
  /// if nobody had asked.
  RgbdTrajectory settle();

 private:
  void load();
  void compare(std::size_t first, std::size_t end);

  MapStore& store_;
  CameraIntrinsics camera_;
  RgbdOptions options_;
  std::optional<RgbdTracker> tracker_;
  bool settled_ = false;  ///< tracker_ is not that of the rows
  std::vector<std::optional<Pose>> told_;
  std::vector<MappingSession::Correction> corrections_;
  std::optional<Fold> fold_;
  std::map<std::size_t, Pose> folded_;
  bool foldStarted_ = false;           ///< since save()
  std::set<std::size_t> newlyFolded_;  ///< since save()
};

}  // namespace estancia
