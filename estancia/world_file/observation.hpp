// Observation: what a frame with depth shows of the space around it, small enough to be kept in a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia {

/// Limit of the depth that is kept [m].
constexpr float farthestDepth = 65.5F;

/// The evidence of one frame, in its camera's frame, of which layers are made again for other poses.
struct Observation {
  /// Every n-th pixel of depth along the optical axis: CV_16U [mm], 0 where unknown; at most 320 wide.
  cv::Mat depth;
  /// Camera of `depth`.
  CameraIntrinsics camera;
  /// What each pixel of `depth` shows, encoded as in objects/object_instance.hpp; empty if not requested.
  cv::Mat segments;
  struct Segment {
    /// Its pixels in `depth`.
    cv::Rect box;
    bool flat = false, atBorder = false;
    /// Mean, red, green, blue.
    std::array<std::uint8_t, 3> color = {};
  };
  /// Info of segment 1, 2 …
  std::vector<Segment> info;
  /// The camera's pose as known when the frame came, which later views depend on; older maps lack it.
  std::optional<Pose> seenFrom;
};

/// `depth`: CV_32F [m], 0 or not finite where unknown; `camera`: of any size. Throws Error (invalidInput).
Observation observe(const cv::Mat& depth, const CameraIntrinsics& camera);

/// Finds the segments of an observation, the maxSegments largest, and returns the planes that it sees, in
/// the camera's frame. `image`: BGR, the same view in any size; may be empty. Throws Error as findClusters().
std::vector<Plane> findSegments(Observation& observation, const cv::Mat& image,
                                const ClusterOptions& options);

/// The planes alone. Throws Error as findClusters().
std::vector<Plane> planesOf(const Observation& observation, const ClusterOptions& options);

/// Its depth [m], CV_32F.
cv::Mat depthOf(const Observation& observation);

/// A segment's points in the camera's frame [m]. `depth`: CV_32F; `segment`: CV_8U, not 0 on it.
PointCloud segmentCloud(const cv::Mat& depth, const cv::Mat& segment, const CameraIntrinsics& camera);

/// For map files; fromBytes() throws Error (corruptFile) unless toBytes() wrote them.
std::string toBytes(const Observation& observation);
Observation observationFromBytes(std::string_view bytes);

}  // namespace estancia
