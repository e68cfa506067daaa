// Leveling: which way is up in a map that tracks its camera itself, by the planes that it sees. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia {

/// The planes that the views of a drive have seen.
class Leveling {
 public:
  /// Adds the planes of a frame, in its camera's frame. Planes of an earlier call are replaced.
  void add(std::size_t frame, std::span<const Plane> planes);
  void drop(std::size_t frame) { views_.erase(frame); }
  void clear() { views_.clear(); }

  /// Up, as a unit vector in the map: the direction to which planes of the largest area are parallel (floor,
  /// tables, ceiling) or perpendicular (walls), at most 45° from the cameras' mean upward direction
  /// (Manhattan world; Coughlan and Yuille, ICCV 1999), refined by least squares. `poses`: of the frames;
  /// what frames without one have seen does not count. Nothing where too little was seen, or planes of one
  /// direction only that is not level.
  std::optional<cv::Vec3d> up(std::span<const std::optional<Pose>> poses) const;

  /// For map files. fromBytes() throws Error (malformedFile, truncatedFile).
  std::string toBytes(std::size_t frame) const;
  void fromBytes(std::size_t frame, const std::string& bytes);

 private:
  struct Face {
    cv::Vec3d normal;   // unit normal, towards the camera
    double weight = 0;  // [m²]
  };
  std::map<std::size_t, std::vector<Face>> views_;
};

/// The rotation that turns `up`, which is not along x, to z, and keeps the heading of a camera along x.
cv::Affine3d levelRotation(const cv::Vec3d& up);

}  // namespace estancia
