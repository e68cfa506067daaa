// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/self_tracking.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/topology/sqlite.hpp"

namespace estancia {
namespace {

using sqlite::Statement;

constexpr const char* trackerTable =
    "CREATE TABLE IF NOT EXISTS tracker(kind TEXT NOT NULL, number INTEGER NOT NULL, bytes BLOB NOT NULL, "
    "PRIMARY KEY(kind, number))";
/// Kinds of rows.
constexpr const char *headRow = "head", *keyframeRow = "keyframe", *frameRow = "frame", *foldRow = "fold",
                     *viewRow = "view";

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
  std::apply([&bytes](auto... value) { (bytes.number(value), ...); }, numbersOf(pose));
  return bytes.bytes();
}

Pose poseFrom(const std::string& row) {
  ByteReader bytes = readerOfRow(row);
  Pose pose;
  for (double* value : {&pose.x, &pose.y, &pose.z, &pose.qx, &pose.qy, &pose.qz, &pose.qw})
    *value = bytes.number<double>();
  if (!pose.isPlausible()) bytes.fail("the pose of a view is not finite");
  return pose;
}

SelfTracking::Fold foldFrom(const std::string& row) {
  ByteReader bytes = readerOfRow(row);
  SelfTracking::Fold fold;
  for (int i = 0; i < 3; ++i) fold.up[i] = bytes.number<double>();
  fold.revision = bytes.number<std::uint64_t>();
  if (const double length = cv::norm(fold.up); !std::isfinite(length) || length < 0.1)
    bytes.fail("there is no up");
  return fold;
}

}  // namespace

bool SelfTracking::isOf(MapStore& store) {
  return Statement(store.database(), "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'tracker'")
      .next();
}

SelfTracking::SelfTracking(MapStore& store, const CameraIntrinsics& camera, const RgbdOptions& options)
    : store_(store), camera_(camera), options_(options) {
  store_.database().run(trackerTable);
  load();
}

/// All that the rows say. They are of the frames that the map has.
void SelfTracking::load() {
  const std::vector<LabelPart> parts = store_.identity().vocabulary.layout().parts;
  settled_ = foldStarted_ = false;
  newlyFolded_.clear();
  folded_.clear();
  fold_.reset();
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
      if (kind == viewRow && number < frames) folded_.emplace(number, poseFrom(rows.blob(2)));
    }
    if (state.head.empty())
      tracker_.emplace(camera_, options_, parts);
    else
      tracker_ = RgbdTracker::restore(camera_, options_, parts, state);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::malformedFile && e.code() != ErrorCode::truncatedFile) throw;
    store_.database().failDamaged(e.what());
  }
  if (tracker_->size() != frames)
    store_.database().failDamaged(fmt::format("its odometry has {} frames of {}", tracker_->size(), frames));
  told_.resize(std::min(told_.size(), frames));
  while (told_.size() < frames) told_.push_back(store_.pose(told_.size()));
  compare(0, frames);
}

/// Notes which of the frames were moved.
void SelfTracking::compare(std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i)
    if (const auto pose = tracker_->at(i).pose; !isSamePose(pose, told_[i])) {
      told_[i] = pose;
      corrections_.push_back({i, pose});
    }
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
  told_.push_back(placement.pose);
  return placement.pose;
}

std::vector<MappingSession::Correction> SelfTracking::takeCorrections() {
  return std::exchange(corrections_, {});
}

void SelfTracking::startFold(const Fold& fold) {
  fold_ = fold;
  folded_.clear();
  newlyFolded_.clear();
  foldStarted_ = true;
}

void SelfTracking::addToFold(std::size_t frame, const Pose& pose) {
  folded_[frame] = pose;
  newlyFolded_.insert(frame);
}

void SelfTracking::save() {
  Statement row(store_.database(), "INSERT OR REPLACE INTO tracker VALUES(?1, ?2, ?3)");
  const auto put = [&row](const char* kind, std::uint64_t number, const std::string& bytes) {
    row.bindAll(kind, static_cast<std::size_t>(number), std::as_bytes(std::span(bytes)));
    row.execute();
  };
  const RgbdTracker::State state = tracker_->save();
  put(headRow, 0, state.head);
  for (const auto& keyframe : state.keyframes) put(keyframeRow, keyframe.number, keyframe.bytes);
  for (const auto& frame : state.frames) put(frameRow, frame.number, frame.bytes);
  if (std::exchange(foldStarted_, false)) {
    Statement(store_.database(), "DELETE FROM tracker WHERE kind = ?1", viewRow).execute();
    ByteWriter bytes;
    for (int i = 0; i < 3; ++i) bytes.number(fold_->up[i]);
    bytes.number(fold_->revision);
    put(foldRow, 0, bytes.bytes());
  }
  for (const std::size_t frame : std::exchange(newlyFolded_, {}))
    put(viewRow, frame, bytesOf(folded_.at(frame)));
}

RgbdTrajectory SelfTracking::settle() {
  tracker_->settle();
  settled_ = true;
  compare(0, std::min(told_.size(), store_.frameCount()));
  return tracker_->trajectory();
}

}  // namespace estancia
