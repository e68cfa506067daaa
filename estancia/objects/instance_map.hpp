// Instance map: segments of frames with known poses become things that last.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <unordered_map>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/objects/object_instance.hpp"

namespace estancia {

struct InstanceMapOptions {
  double voxel = 0.025;
  double consensus = 0.6;
  std::size_t minViews = 4;
};
OptionGroup declare(InstanceMapOptions& options);

/// A place in the voxel grid of a map, along the floor's axes.
struct VoxelKey {
  std::int32_t x = 0, y = 0, z = 0;
  bool operator==(const VoxelKey&) const = default;
  auto operator<=>(const VoxelKey&) const = default;
};
struct VoxelHash {
  std::size_t operator()(const VoxelKey& key) const {
    std::uint64_t h = static_cast<std::uint32_t>(key.x) * 0x9E3779B97F4A7C15ULL;
    h = (h ^ static_cast<std::uint32_t>(key.y)) * 0xC2B2AE3D27D4EB4FULL;
    h = (h ^ static_cast<std::uint32_t>(key.z)) * 0x165667B19E3779F9ULL;
    return h ^ h >> 29;
  }
};

/// Mask clustering by view consensus (Yan et al., "MaskClustering", CVPR 2024): two segments of different
/// frames show one thing if most of the frames that see both have them in one segment. A segment that other
/// frames split is under-segmented and left out, as is one whose place is no segment in most frames: a wall.
/// A frame that sees a wall there has half a vote, since it cannot distinguish one from the front of a
/// cabinet. Parts that float, or lie nearly all inside of a larger thing which they touch, belong to that;
/// clusters of loose pixels belong to the thing that they touch most.
///
/// Memory: a voxel for each 2.5 cm of surface, and about 30 KB a frame. O(pixels) a frame.
class InstanceMap {
 public:
  /// Throws Error (invalidOption).
  explicit InstanceMap(const Floor& floor, const InstanceMapOptions& options = {});

  /// Adds the next frame: depth [m], CV_32F, 0 or not finite where unknown; its segment image
  /// (object_instance.hpp), CV_8U, of the same size; the camera of these images and where it stood.
  /// Frames come by rising number. Throws Error (invalidInput) for other images and numbers.
  void add(std::size_t frame, const cv::Mat& depth, const cv::Mat& segments, const CameraIntrinsics& camera,
           const Pose& pose);

  /// Value of an image of each segment of the frame added last, from segment 1 on: the side of a square of
  /// its pixels, divided by the square of how often its place has been labeled, and once more. So a new small
  /// thing comes before another image of a large one.
  std::vector<double> worthLabeling() const;
  /// An image of this segment has been labeled.
  void labeled(const SegmentPlace& segment);

  /// The things that enough frames show, those with most frames first.
  std::vector<ObjectInstance> instances() const;

  std::size_t frames() const { return heights_.size(); }

  /// A segment in the map.
  struct Mask {
    std::size_t frame = 0, segment = 0, pixels = 0;
    struct Part {
      VoxelKey at;
      /// Mean of its points [m], from the voxel's corner.
      cv::Vec3f inside;
    };
    std::vector<Part> parts;
  };
  struct Voxel {
    /// Frames that see it, a wall counting half; that see a segment there; to which it is loose.
    double seen = 0;
    std::uint32_t masked = 0, loose = 0;
    /// How often a segment here was labeled.
    std::uint32_t labeled = 0;
    /// Numbers of the masks here.
    std::vector<std::uint32_t> masks = {};
  };
  using Voxels = std::unordered_map<VoxelKey, Voxel, VoxelHash>;

 private:
  /// View consensus: groups of masks, ascending and by their first mask, without walls and under-segmented
  /// masks. Pairs that many frames see are merged first (Yan et al. 2024, sections 3.2 and 3.3).
  std::vector<std::vector<std::uint32_t>> clusterMasks() const;

  Floor floor_;
  InstanceMapOptions options_;
  Voxels voxels_;
  std::vector<Mask> masks_;
  std::vector<double> heights_;  // heights of the cameras [m]
  std::size_t newest_ = 0;       // the first mask of the frame added last
};

}  // namespace estancia
