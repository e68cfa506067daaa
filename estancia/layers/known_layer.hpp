// Known layer: which objects of a map are known ones, and their poses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/layers/instance_views.hpp"
#include "estancia/layers/known_objects.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// A view of an instance, in the form that KnownObjects::find() takes.
struct KnownWitness {
  SegmentPlace place;
  /// From the thing to the camera.
  cv::Vec3d direction;
  cv::Mat depth, segment;
  CameraIntrinsics camera;
};

/// Private to WorldMapper. Known objects are looked for when the instances of a drive are known, in their
/// best views: no frame waits for it, a thing is not searched more than three times, and objects can be given
/// after the drive. What was found is kept by segment, in the camera's frame: it moves with the frame.
class KnownLayer {
 public:
  /// Both must outlive it.
  KnownLayer(MapStore& map, const WorldStore& observations) : store_(map), observations_(observations) {}

  /// From now on these are looked for; earlier ones stay found.
  void recognize(std::shared_ptr<const KnownObjects> objects);

  /// The known object that each instance is; `poses`: of kept frames. Ctrl-C leaves the rest for later.
  std::vector<std::optional<KnownPose>> find(std::span<const ObjectInstance> instances,
                                             const FramePoses& poses, const Floor& floor);
  void put(std::span<const std::optional<KnownPose>> found) { store_.putPoses(found); }

 private:
  void search(std::span<const ObjectInstance> instances, const FramePoses& poses, const Floor& floor,
              std::multimap<SegmentPlace, SegmentRecognition>& kept);
  SegmentRecognition recognized(const KnownObjects::Model& model, const KnownWitness& view,
                                const std::vector<KnownWitness>& views, const FramePoses& poses) const;
  std::vector<KnownWitness> load(const std::vector<InstanceView>& views, const FramePoses& poses,
                                 const cv::Vec3d& center) const;

  KnownStore store_;
  const WorldStore& observations_;
  std::shared_ptr<const KnownObjects> objects_;
};

}  // namespace estancia
