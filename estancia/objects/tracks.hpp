// Which clusters of a sequence's frames are the same thing.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

struct TrackOptions {
  double reach = 0.05;       ///< a thing is found again within this or half its size, whichever is more [m]
  double overlap = 0.3;      ///< of the boxes, intersection over union, where frames have no poses
  std::size_t patience = 5;  ///< frames that it may stay unseen
};

/// Clusters → numbers of things, frame by frame.
class Tracks {
 public:
  explicit Tracks(const TrackOptions& options = {});
  ~Tracks();

  /// The thing of each cluster of the next frame: those known before keep their number, new ones get the
  /// next. No two clusters are the same thing. `pose` (T_map_camera) lets the camera move far between frames.
  std::vector<std::size_t> follow(const Clusters& clusters, const std::optional<Pose>& pose);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace estancia
