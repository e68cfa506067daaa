// World mapper implementation: what a map's layers are made of while its frames come. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/areas/plan_areas.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/layers/known_layer.hpp"
#include "estancia/layers/object_layer.hpp"
#include "estancia/layers/shape_layer.hpp"
#include "estancia/layers/work_time.hpp"
#include "estancia/session/session_impl.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/world/drive_faults.hpp"
#include "estancia/world/register_drive.hpp"
#include "estancia/world/self_tracking.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// Views are alike where they are from one cell of half a meter and look in about one direction (30°). The
/// first eight of a cell are kept, then one each time the drive has doubled: for a robot that repeats its
/// round the number of views of a cell grows with the logarithm of the days.
class ViewCells {
 public:
  bool wants(std::size_t frame, const Pose& pose) const {
    const auto cell = cells_.find(keyOf(pose));
    return cell == cells_.end() || cell->second.views < enough || frame >= 2 * cell->second.lastFrame;
  }
  void add(std::size_t frame, const Pose& pose) {
    Cell& cell = cells_[keyOf(pose)];
    ++cell.views;
    cell.lastFrame = frame;
  }

 private:
  static constexpr std::size_t enough = 8;
  static constexpr double width = 0.5;      // [m]
  static constexpr double direction = 0.5;  // edge of a cell of a direction's components: about 30°

  using Key = std::array<std::int64_t, 6>;
  struct Cell {
    std::size_t views = 0, lastFrame = 0;
  };

  /// `pose` is plausible.
  static Key keyOf(const Pose& pose) {
    const auto cellOf = [](double value, double size) {
      return static_cast<std::int64_t>(std::floor(value / size));
    };
    const std::array<double, 3> forward = pose.forward();
    // Middles of cells lie on the axes, so that a camera that looks along one stays in its cell.
    const auto turn = [&](double component) {  // in [-1, 1] also where the quaternion is none of unit length
      return cellOf(std::max(-1.0, std::min(1.0, component)) + direction / 2, direction);
    };
    return {cellOf(pose.x, width), cellOf(pose.y, width), cellOf(pose.z, width),
            turn(forward[0]),      turn(forward[1]),      turn(forward[2])};
  }

  std::map<Key, Cell> cells_;
};

/// WorldMapper::goneOptionsOf() of a map that no session has open.
std::vector<std::string> goneOptionsIn(MapStore& store);

/// Layers of a map while its frames come. For each frame locate() runs before MappingSession::add() and
/// look() after it; the constructor replays the frames of a resumed map in this order. Invariant: `survey`
/// and `objects` hold the views folded so far with `floor` and the poses of that time, and rebuild() makes
/// them anew from the stored observations.
struct WorldMapper::Impl {
  /// Directions of up that differ by less make the same floor.
  static constexpr double sameUp = 0.1 * std::numbers::pi / 180;
  /// Five views a second are taken, whether there is time for them or not.
  static constexpr std::chrono::milliseconds longestUnseen{200};

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
  FramePoses poses;             // poses of the frames that the file keeps, and the newest ones
  std::size_t maxPoses = 4096;  // number of poses at which left-out frames are removed
  Moments mean;                 // mean of the descriptors of all frames
  PoseJumps jumps;              // jumps of given poses
  bool isBelieved = true;       // the newest given pose, by `jumps`
  DepthFaults faults;
  std::optional<Pose> own;       // given pose of the newest frame
  std::optional<Pose> lastView;  // camera pose of this drive's last view
  ViewCells cells;
  ViewCells ownCells;     // view cells of a drive whose poses are not known in the map
  bool isAligned = true;  // whether the drive's poses are in the map, as the layers know it
  std::size_t alignmentsTaken = 0;
  std::optional<Floor> floor;
  bool isTracked = false;                // the poses are those of the odometry
  std::optional<SelfTracking> tracking;  // exists if frames are to be tracked
  std::optional<RgbdTrajectory> odometry;
  std::optional<MapLevel> level;
  std::vector<std::size_t> viewFrames;  // frames of the views, if tracked
  bool foldIsFinal = false;             // if tracked: the layers are those of finish()
  std::optional<FloorSurvey> survey;
  std::optional<ObjectLayer> objects;
  std::size_t views = 0, tooFar = 0, folds = 0;
  WorkTime viewing{longestUnseen};                             // time of a view without labeling its objects
  std::optional<PlannedFrames> planned;                        // the newest plan of areas
  std::shared_ptr<const MappingSession::Impl::Verify> verify;  // what the session asks while this lives

  std::size_t labels() const { return session.store.identity().vocabulary.size(); }

  /// `given`: in the drive's own frame; nothing where it is not known, or the camera is tracked.
  void addFrame(const Frame& frame, const std::optional<Pose>& given, const std::optional<Pose>& pose,
                DescriptorView descriptor) {
    own = given && given->isPlausible() ? given : std::nullopt;
    poses.add(pose && pose->isPlausible() ? pose : std::nullopt);
    mean.add(descriptor);
    isBelieved = isTracked || !own || jumps.add(poses.size() - 1, frame, *own);
  }

  void beginDrive(bool aligned);
  void takeAlignment();
  void forgetLeftOut();
  /// Depth decides about the drive's poses, from the first view on.
  void noteUnaligned(const Pose& from) {
    noteOwnView(from);
    if (verify) return;
    verify = std::make_shared<const MappingSession::Impl::Verify>([this](const cv::Affine3d& guess) {
      return registerDrive(session.store, store, session.drive, guess);
    });
    session.verify = verify;
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
    for (const FramePoses::Entry& entry : poses.entries())
      if (entry.pose) known.push_back(*entry.pose);
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
    survey.emplace(*floor, options.areas.cell, labels());
    if (objects) objects->restart(*floor);
    bool folded = false;
    store.forEachObservation([&](std::size_t frame, const Observation& seen) {
      const std::optional<Pose> pose = poseOf(frame);
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

  /// Keeps what the newest frame saw; returns whether it is in the layers, as its pose is known in the map.
  bool addView(const Observation& seen, DescriptorView descriptor) {
    put(seen, descriptor);
    if (isAligned) {
      if (session.alignment) session.endAlignment();  // what was seen in space stays where it is
      return add(seen, descriptor, *seen.seenFrom);
    }
    noteUnaligned(*seen.seenFrom);
    return false;
  }
  /// Returns the map as it would be read from the file.
  WorldMap read() {
    session.write();
    WorldMap world{session.store.load()};
    store.read(world);
    return world;
  }

  void locate(const Frame& frame, DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth);
  void look(DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth,
            const CameraIntrinsics& camera, const Deadline& deadline);
  std::function<std::optional<PlannedFrames>()> planning(const std::vector<AreaEdit>& corrections) const;
  /// A drive begins that has no frames yet.
  void notePlanBefore() {
    if (!poses.empty() && session.drive.firstFrame == poses.size()) store.keepPlanBefore();
  }
  /// Areas that earlier drives have found keep their numbers, whether this one was interrupted or not.
  void put(PlannedFrames now) {
    if (const auto before = store.planBefore()) keepNumbers(now, *before);
    store.putAreas(now, planned ? &*planned : nullptr);
    planned = std::move(now);
  }
  void replan(PlannedFrames now);
  void putObjects(const std::vector<ObjectInstance>& found);

  // ---- if the camera is tracked
  void startTracking(const CameraIntrinsics& camera);
  std::optional<Pose> track(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                            const cv::Mat& depth);
  void takeCorrections();
  bool isNewTracked(std::size_t frame);
  bool addTracked(Observation& seen, DescriptorView descriptor, const cv::Mat& image);
  void loadFold();
  void foldFinally();

  LexicalDescriptor pending;  // descriptor of the frame that the session does not have yet
  LexicalDescriptor descriptorOf(std::size_t frame) const {
    return frame < session.store.frameCount() ? session.store.descriptor(frame) : pending;
  }
};

}  // namespace estancia
