// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/world_mapper.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/floor_survey.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/topology/session_impl.hpp"
#include "estancia/topology/sqlite.hpp"
#include "estancia/world/object_layer.hpp"
#include "estancia/world/world_store.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {
namespace {

/// Directions of up that differ by less make the same floor.
constexpr double sameUp = 0.1 * std::numbers::pi / 180;

}  // namespace

std::string toString(const WorldLayers& layers) {
  std::string names = "places";
  if (layers.zones) names += ",zones";
  if (layers.areas) names += ",areas";
  if (layers.objects) names += ",objects";
  return names;
}

WorldLayers layersFrom(const std::string& names) {
  WorldLayers layers{false, false, false};
  std::istringstream rest(names);
  for (std::string name; std::getline(rest, name, ',');)
    if (name == "zones")
      layers.zones = true;
    else if (name == "areas")
      layers.areas = true;
    else if (name == "objects")
      layers.objects = true;
    else if (name != "places")
      fail(ErrorCode::unknownName, "a map has no layer \"{}\"; it has places, zones, areas and objects",
           printable(name));
  return layers;
}

OptionGroup declare(WorldOptions& options) {
  OptionGroup group("world", "How a drive becomes areas and objects.");
  group
      .add("layers",
           Option::Text{[&options] { return options.layers ? toString(*options.layers) : std::string(); },
                        [&options](const std::string& names) { options.layers = layersFrom(names); }},
           "What the map holds: places,zones,areas,objects, some of them")
      .automatic("all that the drive allows");
  group.add("view-shift", &options.viewShift, "How far the camera moves to a new view.")
      .range(0, 10)
      .unit("m")
      .why("A robot that stands still sees nothing new.");
  group.add("view-turn", &options.viewTurn, "How far the camera turns to a new view.")
      .range(0, 180)
      .unit("degrees");
  group.add("crops", &options.crops, "Objects that are labeled in a frame: new ones and better views first")
      .range(0, 1000)
      .why("Each costs as much as the frame itself.");
  group.add(declare(options.areas));
  group.add(declare(options.segments));
  group.add(declare(options.objects));
  return group;
}

struct WorldMapper::Impl {
  Impl(MappingSession::Impl& mapping, const WorldOptions& wanted, Labeler* images)
      : session(mapping),
        options(wanted),
        store(mapping.store, MapStore::Access::write),
        mean(mapping.store.identity().vocabulary.size(), false) {
    declare(options).validate();
    edits = store.edits();
    const std::string kept = store.layers();
    if (!kept.empty() && options.layers && *options.layers != layersFrom(kept))
      fail(ErrorCode::mismatch, "the map has the layers {}, which it keeps; leave out --layers, or map anew",
           kept);
    layers = !kept.empty() ? layersFrom(kept) : options.layers.value_or(WorldLayers{});
    if (kept.empty()) store.putLayers(toString(layers));
    if (layers.objects) {
      const bool names = images != nullptr && images->needsImage() && !images->discovers();
      objects.emplace(store, mapping.store.identity().vocabulary, options.objects, names ? images : nullptr,
                      options.crops);
    }
  }

  MappingSession::Impl& session;
  WorldOptions options;
  WorldStore store;
  WorldLayers layers;
  std::vector<AreaEdit> edits;
  std::vector<std::optional<Pose>> poses;  // of all frames
  Moments mean;                            // of their descriptors
  std::optional<Pose> lastView;
  std::optional<Floor> floor;
  std::optional<FloorSurvey> survey;
  std::optional<ObjectLayer> objects;
  std::size_t views = 0, tooFar = 0;

  std::size_t labels() const { return session.store.identity().vocabulary.size(); }

  void addFrame(const std::optional<Pose>& pose, DescriptorView descriptor) {
    poses.push_back(pose && pose->isPlausible() ? pose : std::nullopt);
    mean.add(descriptor);
  }

  bool isNew(const Pose& pose) const {
    if (!lastView) return true;
    const cv::Affine3d motion = rigidOf(*lastView).inv() * rigidOf(pose);
    return cv::norm(motion.translation()) >= options.viewShift ||
           angleOf(motion) >= options.viewTurn * std::numbers::pi / 180;
  }

  /// Adds a view to the layers. Where up is follows from all poses; it is looked at again each time their
  /// number has doubled, and the layers are made anew where it has changed. Returns whether it is in them.
  bool add(const Observation& seen, DescriptorView descriptor, const Pose& pose) {
    lastView = pose;
    ++views;
    if (std::has_single_bit(views)) {  // the view is among those that are folded again
      std::vector<Pose> known;
      for (const auto& p : poses)
        if (p) known.push_back(*p);
      const Floor now(known);
      if (!floor || std::acos(std::clamp(now.up().dot(floor->up()), -1.0, 1.0)) > sameUp) {
        floor = now;
        return rebuild();
      }
    }
    return fold(poses.size() - 1, seen, descriptor, pose);
  }

  bool fold(std::size_t frame, const Observation& seen, DescriptorView descriptor, const Pose& pose) {
    const cv::Mat depth = depthOf(seen);
    try {
      survey->add(descriptor, depth, seen.camera, pose);
    } catch (const Error& e) {
      if (e.code() != ErrorCode::tooLarge) throw;
      ++tooFar;
      return false;
    }
    if (objects) objects->add(frame, depth, seen, pose);
    return true;
  }

  /// The layers of all observations that the map holds. Returns whether the last one is in them.
  bool rebuild() {
    tooFar = 0;
    survey.emplace(*floor, options.areas.cell, labels(), options.areas.words);
    if (objects) objects->restart(*floor);
    bool folded = false;
    store.forEachObservation([&](std::size_t frame, const Observation& seen) {
      if (frame < poses.size() && poses[frame])
        folded = fold(frame, seen, descriptorOf(frame), *poses[frame]);
      return true;
    });
    return folded;
  }

  LexicalDescriptor pending;  // of the frame that the session does not have yet
  LexicalDescriptor descriptorOf(std::size_t frame) const {
    return frame < session.store.frameCount() ? session.store.descriptor(frame) : pending;
  }
};

WorldMapper::WorldMapper(MappingSession& session, const WorldOptions& options, Labeler* labeler)
    : impl_(std::make_unique<Impl>(*session.impl_, options, labeler)) {
  MapStore& store = impl_->session.store;
  // As the frames came, so that the layers are those of an unbroken run.
  std::size_t next = 0;
  const auto upTo = [&](std::size_t end) {
    store.forEachDescriptor(next, [&](std::size_t frame, DescriptorView descriptor) {
      if (frame >= end) return false;
      impl_->addFrame(store.pose(frame), descriptor);
      next = frame + 1;
      return next < end;
    });
  };
  impl_->store.forEachObservation([&](std::size_t frame, const Observation& seen) {
    upTo(frame + 1);
    if (frame < impl_->poses.size() && impl_->poses[frame])
      impl_->add(seen, store.descriptor(frame), *impl_->poses[frame]);
    return true;
  });
  upTo(store.frameCount());
}
WorldMapper::WorldMapper(WorldMapper&&) noexcept = default;
WorldMapper::~WorldMapper() = default;

bool WorldMapper::wantsImages() const {
  return impl_->layers.objects;
}

void WorldMapper::observe(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                          const cv::Mat& depth, const CameraIntrinsics& camera) {
  const std::size_t index = impl_->poses.size();
  impl_->addFrame(frame.pose, descriptor);
  const std::optional<Pose> pose = impl_->poses.back();
  const bool inSpace = impl_->layers.areas || impl_->layers.objects;
  if (!inSpace || !pose || depth.empty() || !impl_->isNew(*pose)) return;
  Observation seen = estancia::observe(depth, camera);
  if (impl_->layers.objects) findSegments(seen, image, impl_->options.segments);
  impl_->store.putObservation(index, seen);
  impl_->pending.assign(descriptor.begin(), descriptor.end());
  if (impl_->add(seen, descriptor, *pose) && impl_->objects) impl_->objects->label(index, seen, image);
}

void WorldMapper::correct(const AreaEdit& edit) {
  impl_->store.addEdit(edit);
  impl_->edits.push_back(edit);
}

void WorldMapper::finish() {
  MapStore& map = impl_->session.store;
  const std::size_t frames = impl_->poses.size();
  if (impl_->layers.zones && frames > 0 && frames <= mostFramesOfZones) {
    ZoneOptions options;
    options.reach = ZoneOptions::reachOfRun;
    try {
      impl_->store.putZones(findZones(readMapDescriptors(map.database().path()), options));
    } catch (const Interrupted&) {  // Ctrl-C ended the mapping: --continue finds them
    }
  }
  std::optional<PlannedFrames> planned;
  if (impl_->layers.areas && impl_->survey && !impl_->survey->grid.cells().empty()) {
    const std::span<const float> mean = impl_->mean.mean();
    try {
      planned = planAreas(*impl_->survey, impl_->poses, map.identity().vocabulary, {mean.begin(), mean.end()},
                          impl_->options.areas.segmentation, impl_->edits);
      impl_->store.putAreas(*planned);
    } catch (const Error& e) {  // so little was seen that there is no room: the map has no areas yet
      if (e.code() != ErrorCode::insufficientData) throw;
    }
  }
  if (impl_->objects) impl_->objects->put(planned ? &planned->plan : nullptr);
  map.commit();
}

std::size_t WorldMapper::viewsTooFar() const {
  return impl_->tooFar;
}

}  // namespace estancia
