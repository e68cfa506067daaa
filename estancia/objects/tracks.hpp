// Object tracking: associates the clusters of successive frames with instances.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia {

/// Clusters → numbers of instances, frame by frame.
class Tracks {
 public:
  /// An object seen: its center in the camera frame, and a box around it that faces the camera [m].
  struct Sighting {
    cv::Vec3d center;
    cv::Rect2d around;  // relative to the center; empty without a box

    double size() const { return std::max(around.width, around.height); }
  };
  struct Track {
    std::size_t number = 0;
    Sighting last;
    std::optional<Pose> pose;  // pose of the camera that saw it
    std::size_t unseen = 0;    // frames since then
  };

  /// The instance of each cluster of the next frame: tracked ones keep their number, new ones get the next,
  /// from 0. One that was not seen for more than 5 frames is forgotten. Each instance gets at most one
  /// cluster, that with the largest overlap. `camera` is that of the boxes. If an instance was seen with a
  /// pose (T_map_camera) and this frame has one, its box is expected where the camera's motion moves it, else
  /// where it was; clusters without boxes go by distance. Throws Error (invalidInput) without focal length.
  std::vector<std::size_t> follow(const Clusters& clusters, const CameraIntrinsics& camera,
                                  const std::optional<Pose>& pose);

  /// The instances that are still tracked, ascending.
  std::vector<std::size_t> tracked() const;

 private:
  std::vector<Track> tracks_;
  std::size_t next_ = 0;
};

}  // namespace estancia
