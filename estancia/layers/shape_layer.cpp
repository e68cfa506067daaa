// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/shape_layer.hpp"

#include <algorithm>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/objects/shape.hpp"

namespace estancia {
namespace {

/// The best views of an instance, whose shapes are described.
constexpr std::size_t maxShapes = 5;

std::vector<LabelProbability> classesOfPool(const LogOpinionPool& pool,
                                            const std::vector<std::string>& names) {
  std::vector<LabelProbability> classes;
  const std::vector<double> pooled = pool.pooled();
  for (std::size_t c = 0; c < pooled.size(); ++c)
    classes.push_back({names[c], static_cast<float>(pooled[c])});
  std::ranges::stable_sort(classes, std::ranges::greater{}, &LabelProbability::probability);
  return classes;
}

}  // namespace

void ShapeLayer::classify(const ObjectModel& model, const std::string& digest) {
  store_.begin(model.targets().names(), digest);
  model_ = model;
}

std::vector<std::vector<LabelProbability>> ShapeLayer::find(std::span<const ObjectInstance> instances,
                                                            const FramePoses& poses) {
  std::vector<std::vector<LabelProbability>> found(instances.size());
  const std::vector<std::string> names = store_.classes();
  if (names.empty()) return found;
  Shapes shapes = store_.probabilities();
  std::vector<std::vector<InstanceView>> views(instances.size());
  if (model_)
    views = bestViews(observations_, instances, poses, maxShapes,
                      [](std::size_t, const Observation::Segment& segment) { return !segment.flat; });
  else
    for (std::size_t i = 0; i < instances.size(); ++i)
      for (const SegmentPlace& place : instances[i].segments) views[i].push_back({place});
  try {
    if (model_) describe(views, shapes);
  } catch (const Interrupted&) {  // Ctrl-C ended the mapping: --continue describes the rest
  }
  for (std::size_t i = 0; i < instances.size(); ++i) {
    LogOpinionPool pool(names.size());
    for (const InstanceView& view : views[i])
      if (const auto shape = shapes.find(view.place); shape != shapes.end() && !shape->second.empty())
        pool.add(shape->second);
    found[i] = classesOfPool(pool, names);
  }
  return found;
}

/// Describes views without a shape, one frame at a time.
void ShapeLayer::describe(std::span<const std::vector<InstanceView>> views, Shapes& shapes) {
  std::map<std::size_t, std::vector<std::size_t>> wanted;
  for (const std::vector<InstanceView>& best : views)
    for (const InstanceView& view : best)
      if (!shapes.contains(view.place)) wanted[view.place.first].push_back(view.place.second);
  for (const auto& [frame, segments] : wanted) {
    if (interrupted()) throw Interrupted("stopped while shapes were described");
    describe(frame, segments, shapes);
  }
}

void ShapeLayer::describe(std::size_t frame, std::span<const std::size_t> segments, Shapes& shapes) {
  const Observation seen = observations_.observation(frame);
  const cv::Mat depth = depthOf(seen);
  ShapeOptions options = model_->shape();
  options.threads = 1;
  std::vector<std::vector<float>> descriptors(segments.size());
  inParallel(segments.size(), static_cast<std::size_t>(usableCores()), [&](std::size_t i) {
    try {
      const cv::Mat mask = seen.segments == static_cast<int>(segments[i]);
      descriptors[i] = describeShape(segmentCloud(depth, mask, seen.camera), options);
    } catch (...) {
      frameFailure("a segment");  // too few points: it has no answer
    }
  });
  Features features = noShapes(options);
  std::vector<std::size_t> described;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    shapes[{frame, segments[i]}] = {};
    if (descriptors[i].empty()) continue;
    features.values.append(descriptors[i]);
    features.frames.emplace_back();
    described.push_back(i);
  }
  if (!described.empty()) {
    const DescriptorMatrix p = model_->predict(features);
    for (std::size_t k = 0; k < described.size(); ++k)
      shapes[{frame, segments[described[k]]}].assign(p.row(k).begin(), p.row(k).end());
  }
  for (const std::size_t segment : segments) store_.put({frame, segment}, shapes[{frame, segment}]);
}

}  // namespace estancia
