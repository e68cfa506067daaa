// Frame: name, timestamp, pose and true room of one image of a sequence.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "estancia/core/pose.hpp"

namespace estancia {

struct Frame {
  /// Unique in its sequence: the file name, or "frame 000123" in a video.
  std::string name;
  /// Seconds; absent where the source has none.
  std::optional<double> timestamp;
  /// T_map_camera; absent where unknown or not finite.
  std::optional<Pose> pose;
  /// The true room, "" where unknown. Used for evaluation, never for mapping.
  std::string room;
};

}  // namespace estancia
