// Frame sources by their names: cameras, and recordings that are played.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "estancia/sequences/sequence.hpp"
#include "estancia/sources/replay_source.hpp"

namespace estancia {

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
