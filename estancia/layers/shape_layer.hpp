// Shape layer: the classes of a trained object model that the objects of a map have by their shapes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/layers/instance_views.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// Private to WorldMapper. Shapes are described when the instances of a drive are known, in their five best
/// views: no frame waits for it, and a model can be given after the drive. Its answers are kept by segment.
class ShapeLayer {
 public:
  /// Both must outlive it.
  ShapeLayer(MapStore& map, const WorldStore& observations) : store_(map), observations_(observations) {}

  /// Reports the classes of `model` from now on and drops those of an earlier model. `digest`: of its file.
  void classify(const ObjectModel& model, const std::string& digest);

  /// The classes of each instance, by the shapes of its best views, pooled (LogOpinionPool); best first, and
  /// empty where no view has an answer: flat segments are none of the classes. Without a model: by the views
  /// that an earlier run described. `poses`: of the frames that the map keeps. Ctrl-C ends the work, and the
  /// rest may be described later.
  std::vector<std::vector<LabelProbability>> find(std::span<const ObjectInstance> instances,
                                                  const FramePoses& poses);

 private:
  using Shapes = std::map<SegmentPlace, std::vector<float>>;
  void describe(std::span<const std::vector<InstanceView>> views, Shapes& shapes);
  void describe(std::size_t frame, std::span<const std::size_t> segments, Shapes& shapes);

  ShapeStore store_;
  const WorldStore& observations_;
  std::optional<ObjectModel> model_;
};

}  // namespace estancia
