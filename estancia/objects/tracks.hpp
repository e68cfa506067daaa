// Which clusters of a sequence's frames are the same thing.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

struct TrackOptions {
  double reach = 0.05;       ///< a thing is found again within this or half its size, whichever is more [m]
  double overlap = 0.3;      ///< of the boxes, intersection over union; 0 … 1
  std::size_t patience = 5;  ///< frames that it may stay unseen
};

/// Clusters → numbers of things, frame by frame.
class Tracks {
 public:
  /// Throws Error on options out of range.
  explicit Tracks(const TrackOptions& options = {});
  ~Tracks();

  /// The thing of each cluster of the next frame: those known before keep their number, new ones get the
  /// next, from 0. No two clusters are the same thing; of several that could be, the boxes that overlap most
  /// are. `camera` is that of the boxes. Where a thing was seen with a pose (T_map_camera) and this frame has
  /// one, its box is looked for where the camera's motion moves it, else where it was; clusters without boxes
  /// go by their distance. Throws Error on a camera without focal length.
  std::vector<std::size_t> follow(const Clusters& clusters, const CameraIntrinsics& camera,
                                  const std::optional<Pose>& pose);

  /// The things that may be found again, ascending; the others never will be.
  std::vector<std::size_t> followed() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace estancia
