// Where the views of a map were taken: cameras that are tracked, and drives that are aligned.
// SPDX-License-Identifier: Apache-2.0

#include "estancia/map_file/sqlite.hpp"
#include "estancia/world/world_mapper_impl.hpp"

namespace estancia {
namespace {

/// 1, 2, 3, 4, 6, 8, 12, 16 … so that all layers can be made anew at a bounded cost for each view.
bool isFoldedAnewAt(std::size_t views) {
  return std::has_single_bit(views) || (views % 3 == 0 && std::has_single_bit(views / 3));
}

}  // namespace

void WorldMapper::Impl::startTracking(const CameraIntrinsics& camera) {
  MapStore& map = session.store;
  if (!inSpace()) return;
  if (!isTracked && !poses.empty()) {
    if (std::ranges::any_of(poses.entries(), [](const auto& entry) { return entry.pose.has_value(); }))
      fail(ErrorCode::mismatch,
           "{} has poses from elsewhere, and these frames have none; give them by --poses, or map anew",
           map.database().path().string());
    return;
  }
  tracking.emplace(map, camera, options.odometry);
  isTracked = foldIsFinal = true;  // the layers are loaded when they are needed
  if (session.drive.firstFrame == poses.size()) tracking->beginDrive();
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
  for (const auto& [frame, pose] : corrections) poses.set(frame, pose);
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

/// Whether the tracked frame shows something new, even where its pose in the map will be known later.
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
    poses.set(frame, tracking->pose(frame));
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

void WorldMapper::Impl::beginDrive(bool aligned) {
  isAligned = aligned;
  alignmentsTaken = session.alignments;
  jumps = {};
  lastView.reset();
  ownCells = {};
  if (tracking) tracking->beginDrive();
  verify.reset();
}

/// Before a frame comes: poses of frames that a file with a budget has left out. Looked for again when there
/// are twice as many, so that a frame's share of the work does not grow.
void WorldMapper::Impl::forgetLeftOut() {
  if (!session.keeper || poses.entries().size() < maxPoses) return;
  session.write();  // then none waits
  poses.keepOnly(session.store.frameNumbers());
  maxPoses = std::max(maxPoses, 2 * poses.entries().size());
}

/// The drive's poses have become known in the map, or better: what it has seen so far is added to the layers.
void WorldMapper::Impl::takeAlignment() {
  if (alignmentsTaken == session.alignments) return;
  alignmentsTaken = session.alignments;
  isAligned = true;
  verify.reset();
  lastView.reset();
  for (const std::size_t frame : session.store.frameNumbers())  // a bounded file lacks some
    if (frame >= session.drive.firstFrame) poses.set(frame, session.store.pose(frame));
  for (const std::size_t frame : store.observedFrames())
    if (frame >= session.drive.firstFrame && poses[frame]) {
      lastView = poses[frame];
      cells.add(frame, *lastView);
      ++views;
    }
  if (!lastView) return;
  if (const Floor now = floorOfPoses(); !floor || !isSameFloor(now)) floor = now;
  rebuild();
}

}  // namespace estancia
