// Tracker state: keyframes, their graph and the latest frame, and the steps of tracking one frame. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "estancia/odometry/keyframe_graph.hpp"
#include "estancia/odometry/prior.hpp"
#include "estancia/odometry/tracker.hpp"

namespace estancia {

namespace odometry {
constexpr std::size_t minLoopKeyframes = 4;  ///< between the ends of a loop
}

/// State of the tracker. Invariants: `placed` and `online` have one entry a frame that was added; a frame
/// hangs on a keyframe of `keyframes`, so its pose follows when `graph` is optimized. Life cycle: add() frame
/// by frame, in order; save() writes what `changedKeyframes` and `changedFrames` name.
struct RgbdTracker::Impl {
  using Alignment = odometry::Alignment;
  using PoseGraphEdge = odometry::PoseGraphEdge;

  /// A frame hangs on a keyframe, and moves with it.
  struct Placed {
    std::uint32_t keyframe = 0;
    Pose inKeyframe;  ///< T_keyframe_frame
  };
  struct Found {
    std::size_t keyframe;
    Alignment alignment;
  };
  /// A frame on its way through add(), whose words are asked for at most once.
  struct Current {
    std::size_t frame;
    const odometry::FrameView& view;
    const FrameFacts& facts;
    std::optional<LexicalDescriptor> known{};

    const LexicalDescriptor& words() {
      if (!known) known = facts.words ? facts.words() : LexicalDescriptor();
      return *known;
    }
  };

  Impl(const CameraIntrinsics& c, const RgbdOptions& chosen, const std::vector<LabelPart>& parts);

  // tracker.cpp
  void begin(const FrameFacts& facts);
  void track(const View& view, const FrameFacts& facts);
  void addTracked(Current& current, const Found& found);
  void place(Current& current, const Found& found);
  void startAnew(Current& current);
  bool promoteLast();
  std::size_t addKeyframe(Current& current, const cv::Affine3d& pose);
  void hang(std::size_t frame, std::size_t keyframe, const cv::Affine3d& inKeyframe);
  void unhang(std::size_t frame);
  void sayGap(const FrameFacts& facts, std::size_t frame);
  cv::Affine3d trackedPose(std::size_t frame) const;
  std::optional<cv::Affine3d> toldPose(std::size_t frame) const;
  std::string problemOf(std::size_t frame) const;
  Placement at(std::size_t frame) const;

  // tracker_fit.cpp
  cv::Affine3d predicted(std::size_t frame) const;
  cv::Affine3d steady(std::size_t frame) const;
  std::vector<cv::Affine3d> guessesByMotion(std::size_t frame) const;
  std::vector<cv::Affine3d> guessesByFeatures(const odometry::FrameView& view) const;
  std::optional<Found> refined(const odometry::FrameView& view, const cv::Affine3d& guess,
                               std::size_t finest) const;
  std::optional<Found> fit(const odometry::FrameView& view, std::size_t frame) const;
  std::optional<Found> relocalize(Current& current) const;
  std::optional<PoseGraphEdge> loop(std::size_t k, std::size_t other, bool byWords,
                                    const odometry::Pyramid& source) const;
  void closeLoops(std::size_t k);

  // tracker_state.cpp
  std::string head() const;
  std::string keyframeRow(std::size_t k) const;
  std::string frameRow(std::size_t frame) const;
  void readHead(const std::string& bytes);
  void readFrameRow(std::size_t frame, const std::string& bytes);

  CameraIntrinsics camera;
  RgbdOptions options;
  odometry::AlignmentOptions how;
  std::size_t threads;

  std::vector<std::optional<Placed>> placed;    ///< poses of every frame
  std::map<std::size_t, std::string> problems;  ///< problems of frames that cannot be aligned
  std::map<std::size_t, std::string> notes;     ///< sentences
  odometry::PriorTrack prior;
  std::optional<double> priorTime;  ///< time of its latest pose [s]
  odometry::Keyframes keyframes;
  odometry::KeyframeGraph graph;
  odometry::MapPoses map;

  bool isCarried = false;  ///< the camera may be anywhere, whatever the last frame was

  View last;  ///< the latest frame with a pose
  std::size_t lastFrame = 0;
  std::optional<double> lastTime;   ///< [s]
  cv::Affine3d lastPose, velocity;  ///< its pose, and its motion a frame
  std::size_t current = 0;          ///< the keyframe of the latest frame

  std::set<std::size_t> changedKeyframes, changedFrames;  ///< since save()
  std::vector<std::optional<Pose>> online;                ///< T_map_camera as add() answered
};

}  // namespace estancia
