// Live frames: the newest frame of a camera, a replayed sequence or ROS 2 topics; never a queue.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/session/session.hpp"

namespace estancia {

struct TopologicalMap;

struct LiveFrame {
  /// Its name is unique in the source; the pose is absent if unknown.
  Frame frame;
  /// BGR, 8 bits, never empty.
  cv::Mat image;
  /// Along the optical axis [m], CV_32F, 0 where unknown; empty where there is none.
  cv::Mat depth;
  /// When it was there to be taken: latency is counted from here.
  std::chrono::steady_clock::time_point arrived;
  /// Frames of the source that were dropped between the last frame taken and this one.
  std::size_t dropped = 0;
};

/// All functions but newest() may be called from other threads.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// For display.
  virtual std::string name() const = 0;
  /// The newest frame that has not been taken yet; waits for it at most `patience`. Nothing where none came,
  /// or a frame could not be read (see trouble()).
  virtual std::optional<LiveFrame> newest(std::chrono::milliseconds patience) = 0;
  /// Whether each frame comes when it is asked for, however late: none is missed.
  virtual bool isOnDemand() const { return false; }
  /// Faults of a recording as a whole: "drive.mcap is cut off …".
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Frames so far that could not be read.
  virtual std::size_t unreadable() const { return 0; }
  /// Before the first frame: `map` goes on with this source. A recording gives no frame again that the map's
  /// last drive has. Returns whether that drive goes on; else the source is another one.
  virtual bool goOnAfter(const TopologicalMap& /*map*/) { return false; }
  /// Before the first frame: how the map keeps the drive.
  virtual DriveStart driveStart() const { return {name()}; }
  /// Whether no frame will come any more: the end of a replay. A camera that goes is waited for.
  virtual bool ended() const { return false; }
  /// Current problem, as a sentence: "no frame from /dev/video0 for 3 s: waiting for it"; "" when all is
  /// well.
  virtual std::string trouble() const { return ""; }
  /// Whether frames have depth and the camera is known: areas and objects need both. May wait for the first
  /// frame.
  virtual bool hasDepth() const { return false; }
  /// Whether frames have poses; else they are tracked where there is depth.
  virtual bool hasPoses() const { return false; }
  /// Camera of images and depth, in any size. Absent where unknown.
  virtual std::optional<CameraIntrinsics> intrinsics() const { return std::nullopt; }
};

struct ReplayOptions {
  double rate = 1;
  double framesPerSecond = 10;
};
OptionGroup declare(ReplayOptions& options);

struct FrameSourceOptions {
  /// How recordings are read.
  SequenceOptions sequence;
  ReplayOptions replay;
};

/// "0", "/dev/video0", "http://…", "rtsp://…": a camera; "ros2:/topic": images of ROS 2; else the path of a
/// recording: a folder, a video, a bag. Throws Error as openSequence() does; unsupportedFile for recordings
/// of words; invalidOption for options of recordings that a camera or a topic does not have;
/// missingDependency.
std::unique_ptr<FrameSource> makeFrameSource(const std::string& source,
                                             const FrameSourceOptions& options = {});

}  // namespace estancia
