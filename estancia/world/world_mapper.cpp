// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/world_mapper.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/floor_survey.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/topology/drive_store.hpp"
#include "estancia/topology/session_impl.hpp"
#include "estancia/topology/sqlite.hpp"
#include "estancia/world/drive_faults.hpp"
#include "estancia/world/edit_areas.hpp"
#include "estancia/world/edit_objects.hpp"
#include "estancia/world/known_layer.hpp"
#include "estancia/world/map_terms.hpp"
#include "estancia/world/object_layer.hpp"
#include "estancia/world/register_drive.hpp"
#include "estancia/world/self_tracking.hpp"
#include "estancia/world/shape_layer.hpp"
#include "estancia/world/view_cells.hpp"
#include "estancia/world/world_store.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {
namespace {

/// Directions of up that differ by less make the same floor.
constexpr double sameUp = 0.1 * std::numbers::pi / 180;

/// Five views a second are taken, whether there is time for them or not.
constexpr std::chrono::milliseconds longestUnseen(200);

/// 1, 2, 3, 4, 6, 8, 12, 16 … so that all layers can be made anew at a bounded cost for each view.
bool isFoldedAnewAt(std::size_t views) {
  return std::has_single_bit(views) || (views % 3 == 0 && std::has_single_bit(views / 3));
}

}  // namespace

struct WorldMapper::Impl {
  Impl(MappingSession::Impl& mapping, const std::optional<WorldOptions>& wanted, Labeler* images)
      : session(mapping),
        terms(mapping.store),
        options(wanted ? *wanted : terms.options().value_or(WorldOptions{})),
        store(mapping.store, MapStore::Access::write),
        recognition(mapping.store, store),
        shapes(mapping.store, store),
        mean(mapping.store.identity().vocabulary.size(), false) {
    declare(options).validate();
    terms.keep(options);
    edits = store.edits();
    const std::string kept = store.layers();
    if (!kept.empty() && options.layers && *options.layers != layersFrom(kept))
      fail(ErrorCode::mismatch, "the map has the layers {}, which it keeps; leave out --layers, or map anew",
           kept);
    layers = !kept.empty() ? layersFrom(kept) : options.layers.value_or(WorldLayers{});
    isTracked = SelfTracking::isOf(session.store);
    if (kept.empty()) store.putLayers(toString(layers));
    if (layers.objects) {
      const bool names = images != nullptr && images->needsImage() && !images->discovers();
      objects.emplace(store, mapping.store.identity().vocabulary, options.objects, names ? images : nullptr,
                      options.crops);
    }
  }

  MappingSession::Impl& session;
  MapTerms terms;
  WorldOptions options;
  WorldStore store;
  KnownLayer recognition;
  ShapeLayer shapes;
  WorldLayers layers;
  std::vector<AreaEdit> edits;
  std::vector<std::optional<Pose>> poses;  // of all frames
  Moments mean;                            // of their descriptors
  PoseJumps jumps;                         // of given poses
  bool isBelieved = true;                  // the latest of them
  DepthFaults faults;
  std::optional<Pose> own;       // of the newest frame, as it was given
  std::optional<Pose> lastView;  // of this drive
  ViewCells cells;
  ViewCells ownCells;     // of a drive whose poses are not known in the map
  bool isAligned = true;  // the drive, as far as the layers know
  std::optional<Floor> floor;
  bool isTracked = false;                // the poses are those of the odometry
  std::optional<SelfTracking> tracking;  // only where frames are to be tracked
  std::optional<RgbdTrajectory> odometry;
  std::optional<MapLevel> level;
  std::vector<std::size_t> viewFrames;  // where tracked
  bool foldIsFinal = false;             // where tracked: the layers are those that finish() made
  std::optional<FloorSurvey> survey;
  std::optional<ObjectLayer> objects;
  std::size_t views = 0, tooFar = 0, folds = 0;
  WorkTime viewing{longestUnseen};       // without the labels of its objects
  std::optional<PlannedFrames> planned;  // the newest

  std::size_t labels() const { return session.store.identity().vocabulary.size(); }

  /// `given`: in the drive's own frame; nothing where it is not known, or the camera is tracked.
  void addFrame(const Frame& frame, const std::optional<Pose>& given, const std::optional<Pose>& pose,
                DescriptorView descriptor) {
    own = given && given->isPlausible() ? given : std::nullopt;
    poses.push_back(pose && pose->isPlausible() ? pose : std::nullopt);
    mean.add(descriptor);
    isBelieved = isTracked || !own || jumps.add(poses.size() - 1, frame, *own);
  }

  void beginDrive(bool aligned);
  void takeAlignment();
  /// Depth decides about the drive's poses, from the first view on.
  void noteUnaligned(const Pose& from) {
    noteOwnView(from);
    if (!session.verify)
      session.verify = [this](const cv::Affine3d& guess) {
        return registerDrive(session.store, store, session.drive, guess);
      };
  }
  void noteOwnView(const Pose& from) {
    lastView = from;
    ownCells.add(poses.size() - 1, from);
  }

  bool inSpace() const { return layers.areas || layers.objects; }

  bool isNew(std::size_t frame, const Pose& pose) const {
    const ViewCells& known = isAligned ? cells : ownCells;
    return !lastView || (isMoved(rigidOf(*lastView).inv() * rigidOf(pose)) && known.wants(frame, pose));
  }

  bool isMoved(const cv::Affine3d& motion) const {
    return cv::norm(motion.translation()) >= options.viewShift ||
           angleOf(motion) >= options.viewTurn * std::numbers::pi / 180;
  }

  /// Adds a view to the layers. Where up is follows from all poses; it is looked at again each time their
  /// number has doubled, and the layers are made anew where it has changed. Returns whether it is in them.
  bool add(const Observation& seen, DescriptorView descriptor, const Pose& pose) {
    lastView = seen.seenFrom.value_or(pose);
    cells.add(poses.size() - 1, *lastView);
    ++views;
    if (std::has_single_bit(views))  // the view is among those that are folded again
      if (const Floor now = floorOfPoses(); !floor || !isSameFloor(now)) {
        floor = now;
        return rebuild();
      }
    return fold(poses.size() - 1, seen, descriptor, pose);
  }

  Floor floorOfPoses() const {
    std::vector<Pose> known;
    for (const auto& pose : poses)
      if (pose) known.push_back(*pose);
    return Floor(known);
  }
  bool isSameFloor(const Floor& other) const {
    return std::acos(std::clamp(other.up().dot(floor->up()), -1.0, 1.0)) <= sameUp;
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
    return rebuild([this](std::size_t frame) { return poses[frame]; });
  }

  bool rebuild(const std::function<std::optional<Pose>(std::size_t)>& poseOf) {
    tooFar = 0;
    ++folds;
    survey.emplace(*floor, options.areas.cell, labels(), options.areas.words);
    if (objects) objects->restart(*floor);
    bool folded = false;
    store.forEachObservation([&](std::size_t frame, const Observation& seen) {
      const std::optional<Pose> pose = frame < poses.size() ? poseOf(frame) : std::nullopt;
      folded = pose && fold(frame, seen, descriptorOf(frame), *pose);
      return true;
    });
    return folded;
  }

  void findFaults(const Frame& frame, const cv::Mat& depth) {
    if (inSpace() && depth.type() == CV_32F && !depth.empty()) faults.add(frame, depth);
    if (own && jumps.found()) faults.add(*jumps.found());
    if (!isBelieved) faults.addDoubted();
  }

  /// Finds the segments, and returns the planes.
  std::vector<Plane> lookAt(Observation& seen, const cv::Mat& image) const {
    return layers.objects ? findSegments(seen, image, options.segments) : planesOf(seen, options.segments);
  }
  void put(const Observation& seen, DescriptorView descriptor) {
    store.putObservation(poses.size() - 1, seen);
    pending.assign(descriptor.begin(), descriptor.end());
  }

  void locate(const Frame& frame, DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth);
  void look(DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth,
            const CameraIntrinsics& camera, const Deadline& deadline);
  std::function<std::optional<PlannedFrames>()> planning(const std::vector<AreaEdit>& corrections) const;
  void put(PlannedFrames now) {
    store.putAreas(now, planned ? &*planned : nullptr);
    planned = std::move(now);
  }
  void replan(PlannedFrames now);
  void putObjects(const std::vector<ObjectInstance>& found);

  // ---- where the camera is tracked
  void startTracking(const CameraIntrinsics& camera);
  std::optional<Pose> track(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                            const cv::Mat& depth);
  void takeCorrections();
  bool isNewTracked(std::size_t frame);
  bool addTracked(Observation& seen, DescriptorView descriptor, const cv::Mat& image);
  void loadFold();
  void foldFinally();

  LexicalDescriptor pending;  // of the frame that the session does not have yet
  LexicalDescriptor descriptorOf(std::size_t frame) const {
    return frame < session.store.frameCount() ? session.store.descriptor(frame) : pending;
  }
};

void WorldMapper::Impl::startTracking(const CameraIntrinsics& camera) {
  MapStore& map = session.store;
  if (!inSpace()) return;
  if (!isTracked && !poses.empty()) {
    if (std::ranges::any_of(poses, &std::optional<Pose>::has_value))
      fail(ErrorCode::mismatch,
           "{} has poses from elsewhere, and these frames have none; give them by --poses, or map anew",
           map.database().path().string());
    return;
  }
  tracking.emplace(map, camera, options.odometry);
  isTracked = foldIsFinal = true;  // the layers are loaded when they are needed
  takeCorrections();
}

/// The frame's pose as far as it is known; earlier ones are moved.
std::optional<Pose> WorldMapper::Impl::track(const Frame& frame, DescriptorView descriptor,
                                             const cv::Mat& image, const cv::Mat& depth) {
  const std::optional<Pose> pose = tracking->add(frame, descriptor, image, depth);
  takeCorrections();
  if (foldIsFinal) loadFold();
  return pose;
}

void WorldMapper::Impl::takeCorrections() {
  const auto corrections = tracking->takeCorrections();
  for (const auto& [frame, pose] : corrections) poses[frame] = pose;
  session.correct(corrections);
}

/// The layers as they were when the last frame was added, from what the map keeps.
void WorldMapper::Impl::loadFold() {
  foldIsFinal = false;
  viewFrames.clear();
  cells = {};
  store.forEachObservation([&](std::size_t frame, const Observation& seen) {
    if (frame >= poses.size()) return true;
    viewFrames.push_back(frame);
    if (seen.seenFrom) cells.add(frame, *seen.seenFrom);
    return true;
  });
  floor.emplace(cv::Vec3d(0, 0, 1));
  if (tracking->fold()) rebuild([this](std::size_t frame) { return tracking->folded(frame); });
}

/// Whether the tracked frame shows something new. Its pose need not be known: the part of the drive that it
/// belongs to may find its place in the map later.
bool WorldMapper::Impl::isNewTracked(std::size_t frame) {
  const RgbdTracker& tracker = tracking->tracker();
  if (!tracker.motion(frame, frame)) return false;
  // The camera was lost there for ever: a camera in the dark shall not fill the file.
  while (!viewFrames.empty() && !tracker.motion(viewFrames.back(), viewFrames.back())) {
    store.dropObservation(viewFrames.back());
    tracking->dropPlanes(viewFrames.back());
    viewFrames.pop_back();
  }
  if (viewFrames.empty()) return true;
  const auto motion = tracker.motion(viewFrames.back(), frame);
  return !motion || (isMoved(rigidOf(*motion)) && (!poses[frame] || cells.wants(frame, *poses[frame])));
}

/// Adds a view to the layers. From time to time the map is leveled, and they are made anew, of all views at
/// the poses that are known now. Returns whether it is in them.
bool WorldMapper::Impl::addTracked(Observation& seen, DescriptorView descriptor, const cv::Mat& image) {
  const std::size_t frame = poses.size() - 1;
  viewFrames.push_back(frame);
  tracking->addPlanes(frame, lookAt(seen, image));
  const bool anew = isFoldedAnewAt(viewFrames.size());
  if (anew) {
    tracking->level();
    takeCorrections();
    poses[frame] = tracking->pose(frame);
  }
  seen.seenFrom = poses[frame];
  if (seen.seenFrom) cells.add(frame, *seen.seenFrom);
  put(seen, descriptor);
  if (anew && !tracking->isFoldCurrent()) {
    tracking->startFold();
    for (const std::size_t view : viewFrames)
      if (poses[view]) tracking->addToFold(view);
    return rebuild();
  }
  if (!poses[frame]) return false;
  tracking->addToFold(frame);
  return fold(frame, seen, descriptor, *poses[frame]);
}

/// All views at the poses that are known now.
void WorldMapper::Impl::foldFinally() {
  if (tracking) {
    odometry = tracking->settle();
    level = tracking->leveled();
    takeCorrections();
  }
  foldIsFinal = true;
  floor = tracking || SelfTracking::hasLevel(session.store) ? Floor(cv::Vec3d(0, 0, 1)) : floorOfPoses();
  rebuild();
}

std::optional<WorldOptions> WorldMapper::optionsOf(MappingSession& session) {
  return MapTerms(session.impl_->store).options();
}

WorldMapper::WorldMapper(MappingSession& session, const std::optional<WorldOptions>& options,
                         Labeler* labeler, const std::optional<CameraIntrinsics>& track)
    : impl_(std::make_unique<Impl>(*session.impl_, options, labeler)) {
  MapStore& store = impl_->session.store;
  // As the frames came, so that the layers are those of an unbroken run.
  const std::vector<Drive> drives = DriveStore(store).drives();
  auto drive = drives.begin();
  std::size_t next = 0;
  const auto upTo = [&](std::size_t end) {
    store.forEachDescriptor(next, [&](std::size_t frame, DescriptorView descriptor) {
      if (frame >= end) return false;
      const Frame known = store.frame(frame);
      if (drive != drives.end() && drive->firstFrame == frame) impl_->beginDrive((drive++)->isAligned);
      const std::optional<Pose> given = DriveStore(store).givenPose(frame);
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
  if (track) impl_->startTracking(*track);
}
WorldMapper::WorldMapper(WorldMapper&&) noexcept = default;
WorldMapper::~WorldMapper() = default;

void WorldMapper::beginDrive() {
  impl_->terms.forgetCamera();
  impl_->beginDrive(impl_->session.drive.isAligned);
}

void WorldMapper::Impl::beginDrive(bool aligned) {
  isAligned = aligned;
  jumps = {};
  lastView.reset();
  ownCells = {};
  session.verify = nullptr;
}

/// The drive's poses have become known in the map: what it has seen so far is added to the layers.
void WorldMapper::Impl::takeAlignment() {
  if (isAligned || !session.drive.isAligned) return;
  isAligned = true;
  session.verify = nullptr;
  lastView.reset();
  for (std::size_t frame = session.drive.firstFrame; frame < poses.size(); ++frame)
    poses[frame] = session.store.pose(frame);
  for (const std::size_t frame : store.observedFrames())
    if (frame >= session.drive.firstFrame && frame < poses.size() && poses[frame]) {
      lastView = poses[frame];
      cells.add(frame, *lastView);
      ++views;
    }
  if (!lastView) return;
  if (const Floor now = floorOfPoses(); !floor || !isSameFloor(now)) floor = now;
  rebuild();
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
  const std::optional<Pose>& pose = poses.back();
  const std::optional<Pose>& from = isAligned ? pose : own;
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
      put(seen, descriptor);
      if (isAligned)
        added = add(seen, descriptor, *pose);
      else
        noteUnaligned(*from);
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
  impl_->poses.resize(std::min(impl_->poses.size(), map.frameCount()));  // Ctrl-C may keep one from the map
  const std::size_t frames = impl_->poses.size();
  impl_->takeAlignment();
  if (impl_->isTracked && frames > 0) {
    impl_->foldFinally();
    map.commit();  // zones are found in the file
  }
  if (impl_->layers.zones && frames > 0 && frames <= mostFramesOfZones) {
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
  session.write();  // the objects' frames are those of the map
  WorldMap world{session.store.load()};
  store.read(world);
  std::vector<int> areas;
  for (const WorldObject& object : world.objects) areas.push_back(areaOfObject(now.plan, object.center));
  put(std::move(now));
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
  return [seen = *survey, where = poses, vocabulary = session.store.identity().vocabulary,
          average = std::vector<float>(words.begin(), words.end()), how = options.areas,
          corrections]() -> std::optional<PlannedFrames> {
    try {
      return planAreas(seen, where, vocabulary, average, how.segmentation, corrections, how.naming);
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
