// One moment of a sequence: what is known of it without its pixels.
#pragma once

#include <optional>
#include <string>

#include "estancia/core/pose.hpp"

namespace estancia {

struct Frame {
  std::string name;                 ///< unique in its sequence: the file name, or "frame 000123" in a video
  std::optional<double> timestamp;  ///< seconds; never guessed where the source has none
  std::optional<Pose> pose;         ///< T_map_camera, absent where unknown or not finite
  std::string room;                 ///< true place, "" where unknown; used to evaluate, never to map
};

}  // namespace estancia
