// SPDX-License-Identifier: Apache-2.0

#include <iterator>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/world/world_mapper_impl.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

std::optional<CameraIntrinsics> cameraToTrack(const Sequence& drive, const WorldOptions& options) {
  const WorldLayers layers = options.layers.value_or(WorldLayers{});
  if (!drive.hasDepth() || !(layers.areas || layers.objects) || hasPoses(drive)) return std::nullopt;
  return drive.intrinsics();
}

WantedWorld WorldMapper::changedOptions(MappingSession& session,
                                        const std::function<void(WorldOptions&)>& change) {
  if (!change) return {};
  WorldOptions options = optionsOf(session).value_or(WorldOptions{});
  change(options);
  return options;
}

std::optional<WorldOptions> WorldMapper::optionsOf(MappingSession& session) {
  return MapTerms(session.impl_->store).options();
}

std::vector<std::string> WorldMapper::goneOptionsOf(MappingSession& session) {
  return goneOptionsIn(session.impl_->store);
}

std::vector<std::string> goneOptionsIn(MapStore& store) {
  std::vector<std::string> gone = goneSettings(store.identity().settings);
  std::ranges::move(MapTerms(store).gone(), std::back_inserter(gone));
  return gone;
}

WorldMapper::WorldMapper(MappingSession& session, Labeler* labeler,
                         const std::optional<CameraIntrinsics>& track,
                         const std::function<void(WorldOptions&)>& change)
    : WorldMapper(session, changedOptions(session, change), labeler, track) {}

WorldMapper::WorldMapper(MappingSession& session, const WantedWorld& options, Labeler* labeler,
                         const std::optional<CameraIntrinsics>& track)
    : impl_(std::make_unique<Impl>(*session.impl_, options.options, labeler)) {
  MapStore& store = impl_->session.store;
  // In the order of the frames, so that the layers equal those of an unbroken run.
  const std::vector<Drive> drives = store.drives();
  auto drive = drives.begin();
  std::size_t next = 0;
  const auto upTo = [&](std::size_t end) {
    store.forEachDescriptor(next, [&](std::size_t frame, DescriptorView descriptor) {
      if (frame >= end) return false;
      const Frame known = store.frame(frame);
      impl_->poses.skipTo(frame);  // the frames in between were left out
      if (drive != drives.end() && drive->firstFrame == frame) impl_->beginDrive((drive++)->isAligned);
      const std::optional<Pose> given = store.givenPose(frame);
      impl_->addFrame(known, given ? given : known.pose, known.pose, descriptor);
      next = frame + 1;
      return next < end;
    });
  };
  impl_->store.forEachObservation([&](std::size_t frame, const Observation& seen) {
    upTo(frame + 1);
    if (impl_->isTracked || frame >= impl_->poses.size()) return true;
    if (impl_->poses[frame])
      impl_->add(seen, store.descriptor(frame), *impl_->poses[frame]);
    else if (impl_->own)
      impl_->noteOwnView(*impl_->own);
    return true;
  });
  upTo(store.frameCount());
  impl_->notePlanBefore();
  if (track) impl_->startTracking(*track);
}
WorldMapper::WorldMapper(WorldMapper&&) noexcept = default;
WorldMapper::~WorldMapper() = default;

void WorldMapper::beginDrive() {
  impl_->terms.forgetCamera();
  impl_->beginDrive(impl_->session.drive.isAligned);
  impl_->notePlanBefore();
}

void WorldMapper::keepCamera(const CameraIntrinsics& camera, double depthScale) {
  impl_->terms.keep(camera, depthScale);
}

const WorldLayers& WorldMapper::layers() const {
  return impl_->layers;
}

bool WorldMapper::tracks() const {
  return impl_->tracking.has_value();
}

bool WorldMapper::wantsImage(const Frame& frame) const {
  return impl_->tracking || (impl_->layers.objects && frame.pose);
}

std::optional<Pose> WorldMapper::observe(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                                         const cv::Mat& depth, const CameraIntrinsics& camera) {
  impl_->locate(frame, descriptor, image, depth);
  impl_->look(descriptor, image, depth, camera, {});
  return impl_->tracking ? impl_->poses.back() : frame.pose;
}

void WorldMapper::observe(const Frame& frame, DescriptorView descriptor, std::optional<Observation> seen) {
  Impl& impl = *impl_;
  impl.forgetLeftOut();
  impl.takeAlignment();
  impl.addFrame(frame, frame.pose, impl.session.inMap(frame.pose), descriptor);
  const std::optional<Pose>& from = impl.isAligned ? impl.poses.back() : impl.own;
  if (!seen || !from || !impl.inSpace()) return;
  seen->seenFrom = from;
  impl.addView(*seen, descriptor);
}

WorldMap WorldMapper::read() {
  return impl_->read();
}

void WorldMapper::add(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                      const cv::Mat& depth, const CameraIntrinsics& camera,
                      const MappingSession::Image& thumbnail, const Placed& placed,
                      const Deadline& deadline) {
  impl_->locate(frame, descriptor, image, depth);
  Frame located = frame;
  if (impl_->tracking) located.pose = impl_->poses.back();
  const int place = impl_->session.add(located, descriptor, thumbnail);
  placed(place, impl_->poses.back());
  impl_->look(descriptor, image, depth, camera, deadline);
  impl_->session.writeWhenDue();  // the frame and what it shows are kept together
}

/// Takes the frame that comes next, and where it is.
void WorldMapper::Impl::locate(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                               const cv::Mat& depth) {
  if (isTracked && !tracking)
    fail(
        ErrorCode::mismatch,
        "{} has the poses of its own odometry: go on without --poses, with depth and its camera, or map anew",
        session.store.database().path().string());
  forgetLeftOut();
  takeAlignment();
  if (tracking)
    addFrame(frame, std::nullopt, track(frame, descriptor, image, depth), descriptor);
  else
    addFrame(frame, frame.pose, session.inMap(frame.pose), descriptor);
  findFaults(frame, depth);
}

/// Takes what that frame shows.
void WorldMapper::Impl::look(DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth,
                             const CameraIntrinsics& camera, const Deadline& deadline) {
  const std::size_t index = poses.size() - 1;
  const std::optional<Pose>& from = isAligned ? poses.back() : own;
  const bool isNewView = tracking ? isNewTracked(index) : from && isBelieved && isNew(index, *from);
  if (inSpace() && !depth.empty() && isNewView && viewing.isDue(deadline)) {
    Observation seen;
    bool added = false;
    viewing.run([&] {
      seen = estancia::observe(depth, camera);
      if (tracking) {
        added = addTracked(seen, descriptor, image);
        return;
      }
      seen.seenFrom = from;
      if (layers.objects) lookAt(seen, image);
      added = addView(seen, descriptor);
    });
    if (added && objects) objects->label(index, seen, image, deadline);
  }
  if (tracking) tracking->save();
}

void WorldMapper::recognize(std::shared_ptr<const KnownObjects> objects) {
  impl_->recognition.recognize(std::move(objects));
}

void WorldMapper::classify(const ObjectModel& model, const std::string& digest) {
  impl_->shapes.classify(model, digest);
}

void WorldMapper::finish() {
  MapStore& map = impl_->session.store;
  impl_->poses.truncate(map.frameCount());  // Ctrl-C may keep one from the map
  const std::size_t frames = impl_->poses.size();
  impl_->takeAlignment();
  if (impl_->isTracked && frames > 0) {
    impl_->foldFinally();
    map.commit();  // zones are found in the file
  }
  if (impl_->layers.zones && frames > 0 && frames <= maxFramesOfZones) {
    ZoneOptions options;
    options.reach = ZoneOptions::reachOfRun;
    options.naming = impl_->options.areas.naming;
    try {
      impl_->store.putZones(findZones(readMapDescriptors(map.database().path()), options));
    } catch (const Interrupted&) {  // Ctrl-C ended the mapping: --continue finds them
    }
  }
  if (auto planned = impl_->planning(impl_->edits)()) impl_->put(std::move(*planned));
  if (impl_->objects) impl_->putObjects(impl_->objects->instances());
  if (impl_->session.keeper) impl_->store.forgetAreasOfMissingFrames();
  map.commit();
}

struct WorldMapper::Derived {
  std::size_t edits = 0, folds = 0;
  std::optional<PlannedFrames> planned;
  std::vector<ObjectInstance> found;
};

WorldMapper::Derivation WorldMapper::derivation() const {
  return [derived = Derived{impl_->edits.size(), impl_->folds, {}, {}}, plan = impl_->planning(impl_->edits),
          find = impl_->objects ? impl_->objects->finding() : nullptr] {
    auto result = std::make_shared<Derived>(derived);
    result->planned = plan();
    if (find) result->found = find();
    return std::shared_ptr<const Derived>(std::move(result));
  };
}

bool WorldMapper::refresh(const Derived& derived) {
  Impl& impl = *impl_;
  if (derived.edits != impl.edits.size() || derived.folds != impl.folds) return false;
  if (derived.planned) impl.put(*derived.planned);
  impl.putObjects(derived.found);
  impl.session.write();
  if (impl.session.keeper) impl.store.forgetAreasOfMissingFrames();
  return true;
}

void WorldMapper::edit(const AreaEdit& edit) {
  Impl& impl = *impl_;
  if (edit.kind != AreaEdit::Kind::name) {
    const auto before = impl.planning(impl.edits)();
    if (!before) fail(ErrorCode::insufficientData, "the map has no areas yet; wait until it has");
    std::vector<AreaEdit> edits = impl.edits;
    edits.push_back(edit);
    auto after = impl.planning(edits)();
    if (edit.kind == AreaEdit::Kind::split && after->plan.areas.size() == before->plan.areas.size())
      failUncut(edit);
    impl.replan(std::move(*after));
  }
  impl.edits.push_back(edit);
  impl.store.addEdit(edit);
  impl.session.write();
}

/// Objects are as they were, but for their areas.
void WorldMapper::Impl::replan(PlannedFrames now) {
  const WorldMap world = read();
  put(std::move(now));
  std::vector<int> areas;
  for (const WorldObject& object : world.objects) areas.push_back(areaOfObject(planned->plan, object.center));
  store.putObjectAreas(areas);
}

void WorldMapper::edit(const ObjectEdit& edit) {
  impl_->session.write();
  putObjectEdit(impl_->session.store, edit);
  impl_->session.store.commit();
}

/// Nothing where the map has no areas, or so little was seen that there is no room.
std::function<std::optional<PlannedFrames>()> WorldMapper::Impl::planning(
    const std::vector<AreaEdit>& corrections) const {
  if (!layers.areas || !survey || survey->grid.cells().empty()) return [] { return std::nullopt; };
  const std::span<const float> words = mean.mean();
  std::vector<std::size_t> starts;
  for (const Drive& drive : session.store.drives()) starts.push_back(drive.firstFrame);
  return [seen = *survey, where = poses, starts, vocabulary = session.store.identity().vocabulary,
          average = std::vector<float>(words.begin(), words.end()), how = options.areas,
          corrections]() -> std::optional<PlannedFrames> {
    try {
      return planAreas(seen, {where, starts}, vocabulary, average, how.segmentation, corrections, how.naming);
    } catch (const Error& e) {
      if (e.code() != ErrorCode::insufficientData) throw;
      return std::nullopt;
    }
  };
}

void WorldMapper::Impl::putObjects(const std::vector<ObjectInstance>& found) {
  if (!objects || !floor) return;
  std::vector<std::optional<KnownPose>> known = recognition.find(found, poses, *floor);
  const AreaPlan* plan = planned ? &planned->plan : nullptr;
  const std::vector<WorldObject> kept = objects->put(found, plan, known, shapes.find(found, poses));
  known.clear();
  for (const WorldObject& object : kept) known.push_back(object.known);
  recognition.put(known);
}

const std::optional<RgbdTrajectory>& WorldMapper::odometry() const {
  return impl_->odometry;
}

const std::optional<MapLevel>& WorldMapper::level() const {
  return impl_->level;
}

const DriveFaults& WorldMapper::faults() const {
  return impl_->faults.faults();
}

std::size_t WorldMapper::viewsTooFar() const {
  return impl_->tooFar;
}

}  // namespace estancia
