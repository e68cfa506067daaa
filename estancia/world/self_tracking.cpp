// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/self_tracking.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/pose_bytes.hpp"
#include "estancia/map_file/sqlite.hpp"

namespace estancia {
namespace {

using sqlite::Statement;

constexpr const char* trackerTable =
    "CREATE TABLE IF NOT EXISTS tracker(kind TEXT NOT NULL, number INTEGER NOT NULL, bytes BLOB NOT NULL, "
    "PRIMARY KEY(kind, number))";
/// Kinds of rows.
constexpr const char *headRow = "head", *keyframeRow = "keyframe", *frameRow = "frame", *foldRow = "fold",
                     *viewRow = "view", *planesRow = "planes", *levelRow = "level";
/// Tolerance of level during a drive [rad]: a correction moves everything that was seen.
constexpr double roughlyLevel = 0.05 * std::numbers::pi / 180;
/// Tolerance at the end [rad]: 1 mm at 6 m.
constexpr double exactlyLevel = 0.01 * std::numbers::pi / 180;

auto numbersOf(const Pose& pose) {
  return std::tuple(pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz, pose.qw);
}

bool isSamePose(const std::optional<Pose>& a, const std::optional<Pose>& b) {
  return a.has_value() == b.has_value() && (!a || numbersOf(*a) == numbersOf(*b));
}

ByteReader readerOfRow(const std::string& bytes) {
  return {bytes, "the state of the odometry", "make the map anew"};
}

std::string bytesOf(const Pose& pose) {
  ByteWriter bytes;
  write(bytes, pose);
  return bytes.bytes();
}

Pose poseFrom(const std::string& row) {
  ByteReader bytes = readerOfRow(row);
  return readPose(bytes);
}

std::string bytesOf(const cv::Vec3d& direction) {
  ByteWriter bytes;
  for (int i = 0; i < 3; ++i) bytes.number(direction[i]);
  return bytes.bytes();
}

cv::Vec3d upFrom(ByteReader& bytes) {
  cv::Vec3d up;
  for (int i = 0; i < 3; ++i) up[i] = bytes.number<double>();
  // `up` has unit length; the first camera, which looks along x, is tilted by about 45° at most.
  if (!(std::abs(cv::norm(up) - 1) < 1e-3) || std::abs(up[0]) > 0.999) bytes.fail("there is no up");
  return up;
}

SelfTracking::Fold foldFrom(const std::string& row) {
  ByteReader bytes = readerOfRow(row);
  SelfTracking::Fold fold;
  fold.up = upFrom(bytes);
  fold.revision = bytes.number<std::uint64_t>();
  return fold;
}

cv::Vec3d levelFrom(const std::string& row) {
  ByteReader bytes = readerOfRow(row);
  return upFrom(bytes);
}

std::optional<Pose> turned(const std::optional<Pose>& pose, const cv::Vec3d& up,
                           const cv::Affine3d& rotation) {
  if (!pose || up == cv::Vec3d(0, 0, 1)) return pose;
  return poseOf(rotation * rigidOf(*pose));
}

}  // namespace

bool SelfTracking::isOf(MapStore& store) {
  return sqlite::hasTable(store.database(), "tracker");
}

bool SelfTracking::hasLevel(MapStore& store) {
  return isOf(store) &&
         Statement(store.database(), "SELECT 1 FROM tracker WHERE kind = ?1 LIMIT 1", levelRow).next();
}

SelfTracking::SelfTracking(MapStore& store, const CameraIntrinsics& camera, const RgbdOptions& options)
    : store_(store), camera_(camera), options_(options) {
  store_.database().run(trackerTable);
  load();
}

/// Restores the state from the rows, which belong to the frames of the map.
void SelfTracking::load() {
  const std::vector<LabelPart> parts = store_.identity().vocabulary.layout().parts;
  settled_ = foldStarted_ = false;
  newlyFolded_.clear();
  folded_.clear();
  fold_.reset();
  planes_.clear();
  newPlanes_.clear();
  newLevel_ = false;
  cv::Vec3d up(0, 0, 1);
  const std::size_t frames = store_.frameCount();
  RgbdTracker::State state;
  try {
    Statement rows(store_.database(), "SELECT kind, number, bytes FROM tracker ORDER BY kind, number");
    while (rows.next()) {
      const std::string kind = rows.text(0);
      const auto number = static_cast<std::uint64_t>(rows.integer(1));
      if (kind == headRow) state.head = rows.blob(2);
      if (kind == keyframeRow) state.keyframes.push_back({number, rows.blob(2)});
      if (kind == frameRow) state.frames.push_back({number, rows.blob(2)});
      if (kind == foldRow) fold_ = foldFrom(rows.blob(2));
      if (kind == levelRow) up = levelFrom(rows.blob(2));
      if (kind == planesRow && number < frames) planes_.fromBytes(number, rows.blob(2));
      if (kind == viewRow && number < frames) folded_.emplace(number, poseFrom(rows.blob(2)));
    }
    if (state.head.empty())
      tracker_.emplace(camera_, options_, parts);
    else
      tracker_ = RgbdTracker::restore(camera_, options_, parts, state);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::malformedFile && e.code() != ErrorCode::truncatedFile) throw;
    store_.database().failDamaged("{}", e.what());
  }
  if (tracker_->size() != frames)
    store_.database().failDamaged("its odometry has {} frames of {}", tracker_->size(), frames);
  take(up);
  const std::size_t known = std::min(told_.size(), frames);
  told_.resize(known);
  told_.resize(frames);
  for (const std::size_t frame : store_.frameNumbers())
    if (frame >= known) told_[frame] = store_.pose(frame);
  compare(0, frames);
  origin_ = origin();
}

/// Notes which of the frames were moved.
void SelfTracking::compare(std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i)
    if (const auto pose = leveled(tracker_->at(i).pose); !isSamePose(pose, told_[i])) {
      told_[i] = pose;
      corrections_.push_back({i, pose});
    }
}

void SelfTracking::beginDrive() {
  if (settled_) load();
  tracker_->beginDrive();
}

std::optional<Pose> SelfTracking::add(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                                      const cv::Mat& depth) {
  if (settled_) load();
  const std::uint64_t revision = tracker_->revision();
  FrameFacts facts{frame.name, frame.timestamp, std::nullopt, {}};
  facts.words = [descriptor] { return LexicalDescriptor(descriptor.begin(), descriptor.end()); };
  const auto placement = depth.empty()   ? tracker_->skip("its depth cannot be read", facts)
                         : image.empty() ? tracker_->skip("its image cannot be read", facts)
                                         : tracker_->add(image, depth, facts);
  const std::size_t newest = told_.size();
  std::size_t first = newest;
  if (tracker_->revision() != revision)
    first = 0;
  else if (placement.why.empty())  // what lies between two tracked frames is bridged
    while (first > 0 && !tracker_->at(first - 1).why.empty()) --first;
  compare(first, newest);
  told_.push_back(leveled(placement.pose));
  if (tracker_->revision() != revision || (!origin_ && told_.back())) {
    const auto before = std::exchange(origin_, origin());
    if (before && origin_ && *before != *origin_)
      level();  // another part of the drive is the map: other axes
  }
  return told_.back();
}

void SelfTracking::addPlanes(std::size_t frame, std::span<const Plane> planes) {
  planes_.add(frame, planes);
  newPlanes_.insert(frame);
}

void SelfTracking::dropPlanes(std::size_t frame) {
  planes_.drop(frame);
  newPlanes_.erase(frame);
  store_.database().execute("DELETE FROM tracker WHERE kind = ?1 AND number = ?2", planesRow, frame);
}

void SelfTracking::level() {
  level(roughlyLevel);
}

void SelfTracking::level(double tolerance) {
  const std::optional<cv::Vec3d> seen = planes_.up(told_);
  std::vector<Pose> known;
  if (!seen)
    for (const auto& pose : told_)
      if (pose) known.push_back(*pose);
  const cv::Vec3d up = seen ? *seen : Floor(known).up();
  leveled_.byPlanes = seen.has_value();
  newLevel_ = newLevel_ || !hasLevel(store_);
  if (std::acos(std::clamp(up[2], -1.0, 1.0)) > tolerance) {
    take(rotation_.rotation().t() * up);
    newLevel_ = true;
    // The latest frame is not in the map yet: its pose is asked for.
    const std::size_t frames = std::min(told_.size(), store_.frameCount());
    compare(0, frames);
    for (std::size_t i = frames; i < told_.size(); ++i) told_[i] = leveled(tracker_->at(i).pose);
  }
  leveled_.tilt = std::acos(std::clamp(up_[2], -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// `up` in the tracker's map.
void SelfTracking::take(const cv::Vec3d& up) {
  up_ = cv::normalize(up);
  rotation_ = levelRotation(up_);
}

std::optional<Pose> SelfTracking::leveled(const std::optional<Pose>& pose) const {
  return turned(pose, up_, rotation_);
}

/// The first frame that is in the map, whose camera the tracker takes for level.
std::optional<std::size_t> SelfTracking::origin() const {
  const auto first = std::ranges::find_if(told_, &std::optional<Pose>::has_value);
  return first == told_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(first - told_.begin()));
}

std::optional<Pose> SelfTracking::folded(std::size_t frame) const {
  const auto pose = folded_.find(frame);
  if (pose == folded_.end() || !fold_) return std::nullopt;
  return turned(pose->second, fold_->up, levelRotation(fold_->up));
}

void SelfTracking::startFold() {
  fold_ = {up_, tracker_->revision()};
  folded_.clear();
  newlyFolded_.clear();
  foldStarted_ = true;
}

void SelfTracking::addToFold(std::size_t frame) {
  const auto pose = tracker_->at(frame).pose;
  if (!pose) return;
  folded_[frame] = *pose;
  newlyFolded_.insert(frame);
}

void SelfTracking::save() {
  Statement row(store_.database(), "INSERT OR REPLACE INTO tracker VALUES(?1, ?2, ?3)");
  const auto put = [&row](const char* kind, std::uint64_t number, const std::string& bytes) {
    row.executeWith(kind, static_cast<std::size_t>(number), std::as_bytes(std::span(bytes)));
  };
  const RgbdTracker::State state = tracker_->save();
  put(headRow, 0, state.head);
  for (const auto& keyframe : state.keyframes) put(keyframeRow, keyframe.number, keyframe.bytes);
  for (const auto& frame : state.frames) put(frameRow, frame.number, frame.bytes);
  for (const std::size_t frame : std::exchange(newPlanes_, {})) put(planesRow, frame, planes_.toBytes(frame));
  if (std::exchange(newLevel_, false)) put(levelRow, 0, bytesOf(up_));
  if (std::exchange(foldStarted_, false)) {
    store_.database().execute("DELETE FROM tracker WHERE kind = ?1", viewRow);
    ByteWriter revision;
    revision.number(fold_->revision);
    put(foldRow, 0, bytesOf(fold_->up) + revision.bytes());
  }
  for (const std::size_t frame : std::exchange(newlyFolded_, {}))
    put(viewRow, frame, bytesOf(folded_.at(frame)));
}

RgbdTrajectory SelfTracking::settle() {
  tracker_->settle();
  settled_ = true;
  compare(0, std::min(told_.size(), store_.frameCount()));
  level(exactlyLevel);
  RgbdTrajectory trajectory = tracker_->trajectory();
  for (auto* poses : {&trajectory.poses, &trajectory.online})
    for (std::optional<Pose>& pose : *poses) pose = leveled(pose);
  return trajectory;
}

}  // namespace estancia
