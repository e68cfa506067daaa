// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose_bytes.hpp"
#include "estancia/core/removed_options.hpp"
#include "estancia/odometry/tracker_impl.hpp"

namespace estancia {
namespace {

constexpr std::uint32_t stateVersion = 1;
constexpr std::string_view stateName = "the state of the odometry";
constexpr std::string_view stateRemedy = "make the map anew";

ByteReader readerOf(std::string_view bytes) {
  return {bytes, std::string(stateName), std::string(stateRemedy)};
}

void writeTime(const std::optional<double>& time, ByteWriter& bytes) {
  bytes.number(static_cast<std::uint8_t>(time ? 1 : 0));
  bytes.number(time.value_or(0));
}

std::optional<double> readTime(ByteReader& bytes) {
  const bool known = bytes.number<std::uint8_t>() != 0;
  const auto time = bytes.number<double>();
  return known ? std::optional(time) : std::nullopt;
}

void requireEnd(const ByteReader& bytes) {
  if (bytes.remaining() > 0) bytes.fail("a row holds more than it should");
}

/// Options and camera as text, without the options that change no result: a state goes on with the same ones
/// only. Removed options are written with the values in files of older programs.
std::string settingsOf(const RgbdOptions& o, const CameraIntrinsics& c) {
  return fmt::format(
      "{} {} {} {} {} {}; term {}; max-width {}; max-depth {}; keyframe-overlap {}; min-overlap 0.35; "
      "max-rmse 0.03; min-correlation 0.5; max-motion 0.7; max-turn 50; max-gap 1; odom-shift {}; odom-turn "
      "{}; min-correction {}; loop-candidates {}; min-loop-keyframes 4; min-loop-overlap 0.4; "
      "min-loop-features {}; threads 0",
      c.width, c.height, c.fx, c.fy, c.cx, c.cy, o.term, o.maxWidth, o.maxDepth, o.keyframeOverlap,
      o.odomShift, o.odomTurn, o.minCorrection, o.loopCandidates, o.minLoopFeatures);
}

/// Without the options that have gone, which an older program may have had other values of.
std::string comparable(const std::string& settings) {
  std::string kept;
  for (std::size_t begin = 0; begin < settings.size();) {
    const std::size_t end = std::min(settings.find("; ", begin), settings.size());
    const std::string each = settings.substr(begin, end - begin);
    const RemovedOption* removed = findRemovedOption("odometry." + each.substr(0, each.find(' ')));
    if (removed == nullptr) kept += each + "; ";
    begin = end + 2;
  }
  return kept;
}

/// Content of a frame's row.
enum Holds : std::uint8_t { placement = 1, priorPose = 2, problem = 4, note = 8 };

}  // namespace

std::string RgbdTracker::Impl::head() const {
  ByteWriter bytes;
  bytes.number(stateVersion);
  bytes.text(settingsOf(options, camera));
  bytes.number(static_cast<std::uint64_t>(placed.size()));
  bytes.number(static_cast<std::uint64_t>(keyframes.size()));
  writeTime(priorTime, bytes);
  for (std::size_t k = 0; k < keyframes.size(); ++k) odometry::write(keyframes.pose(k), bytes);
  std::vector<double> off;
  for (const auto& edge : graph.edges()) off.push_back(edge.off);
  bytes.numbers(off);
  map.write(bytes);
  if (!last) return bytes.bytes();
  write(last->image, bytes);
  write(last->features, bytes);
  bytes.number(static_cast<std::uint64_t>(lastFrame));
  writeTime(lastTime, bytes);
  odometry::write(lastPose, bytes);
  odometry::write(velocity, bytes);
  bytes.number(static_cast<std::uint64_t>(current));
  return bytes.bytes();
}

/// After the rows.
void RgbdTracker::Impl::readHead(const std::string& text) {
  ByteReader bytes = readerOf(text);
  bytes.number<std::uint32_t>(), bytes.text();  // restore() has read them
  bytes.number<std::uint64_t>(), bytes.number<std::uint64_t>();
  priorTime = readTime(bytes);
  for (std::size_t k = 0; k < keyframes.size(); ++k) keyframes.move(k, odometry::readTransform(bytes));
  const std::vector<double> off = bytes.numbers<double>();
  if (off.size() != graph.edges().size()) bytes.fail("edges of its pose graph are missing");
  for (std::size_t e = 0; e < off.size(); ++e) graph.setOff(e, off[e]);
  std::vector<std::size_t> framesOf(keyframes.size());
  for (const auto& frame : placed)
    if (frame) ++framesOf[frame->keyframe];
  map.read(graph, std::move(framesOf), bytes);
  if (keyframes.size() == 0) return;
  odometry::FrameView view;
  view.image = odometry::readPackedImage(bytes);
  view.pyramid = pyramidOf(view.image);
  view.features = odometry::readFeatures(bytes);
  last = std::make_shared<const odometry::FrameView>(std::move(view));
  lastFrame = bytes.number<std::uint64_t>();
  lastTime = readTime(bytes);
  lastPose = odometry::readTransform(bytes);
  velocity = odometry::readTransform(bytes);
  current = bytes.number<std::uint64_t>();
  if (lastFrame >= placed.size() || current >= keyframes.size()) bytes.fail("its latest frame is missing");
  requireEnd(bytes);
}

std::string RgbdTracker::Impl::keyframeRow(std::size_t k) const {
  ByteWriter bytes;
  keyframes.write(k, bytes);
  graph.write(k, bytes);
  return bytes.bytes();
}

std::string RgbdTracker::Impl::frameRow(std::size_t frame) const {
  const auto& entry = prior.at(frame);
  const auto why = problems.find(frame), said = notes.find(frame);
  ByteWriter bytes;
  bytes.number(static_cast<std::uint8_t>((placed[frame] ? placement : 0) | (entry ? priorPose : 0) |
                                         (why != problems.end() ? problem : 0) |
                                         (said != notes.end() ? note : 0)));
  if (placed[frame]) {
    bytes.number(placed[frame]->keyframe);
    write(bytes, placed[frame]->inKeyframe);
  }
  if (entry) {
    write(bytes, entry->pose);
    bytes.number(entry->run);
  }
  if (why != problems.end()) bytes.text(why->second);
  if (said != notes.end()) bytes.text(said->second);
  return bytes.bytes();
}

void RgbdTracker::Impl::readFrameRow(std::size_t frame, const std::string& text) {
  ByteReader bytes = readerOf(text);
  const auto holds = bytes.number<std::uint8_t>();
  placed.emplace_back();
  if ((holds & placement) != 0) {
    const auto keyframe = bytes.number<std::uint32_t>();
    if (keyframe >= keyframes.size()) bytes.fail("a keyframe is missing");
    placed.back() = Placed{keyframe, readPose(bytes)};
  }
  if ((holds & priorPose) != 0) {
    const Pose pose = readPose(bytes);
    prior.restore(frame, {pose, bytes.number<std::uint32_t>()});
  }
  if ((holds & problem) != 0) problems[frame] = bytes.text();
  if ((holds & note) != 0) notes[frame] = bytes.text();
  requireEnd(bytes);
}

RgbdTracker::State RgbdTracker::save() {
  State state{impl_->head(), {}, {}};
  for (const std::size_t k : std::exchange(impl_->changedKeyframes, {}))
    if (k < impl_->keyframes.size()) state.keyframes.push_back({k, impl_->keyframeRow(k)});
  for (const std::size_t frame : std::exchange(impl_->changedFrames, {}))
    state.frames.push_back({frame, impl_->frameRow(frame)});
  return state;
}

RgbdTracker RgbdTracker::restore(const CameraIntrinsics& camera, const RgbdOptions& options,
                                 const std::vector<LabelPart>& parts, const State& state) {
  RgbdTracker tracker(camera, options, parts);
  Impl& impl = *tracker.impl_;
  ByteReader head = readerOf(state.head);
  if (const auto version = head.number<std::uint32_t>(); version != stateVersion)
    head.fail(fmt::format("its version is {}, and {} is known", version, stateVersion));
  if (comparable(head.text()) != comparable(settingsOf(options, camera)))
    fail(ErrorCode::mismatch, "{} was made with other options or another camera; give the same, or {}",
         stateName, stateRemedy);
  const auto frames = head.number<std::uint64_t>(), keyframes = head.number<std::uint64_t>();
  const auto inOrder = [&head](const std::vector<Row>& rows, std::uint64_t count) {
    std::vector<const Row*> sorted;
    for (const Row& row : rows)
      if (row.number < count) sorted.push_back(&row);
    std::ranges::sort(sorted, {}, &Row::number);
    if (sorted.size() != count || (count > 0 && sorted.back()->number != count - 1))
      head.fail("rows are missing");
    return sorted;
  };
  for (const Row* row : inOrder(state.keyframes, keyframes)) {
    ByteReader bytes = readerOf(row->bytes);
    impl.keyframes.read(bytes);
    impl.graph.read(row->number, bytes);
    requireEnd(bytes);
  }
  for (const Row* row : inOrder(state.frames, frames)) impl.readFrameRow(row->number, row->bytes);
  impl.readHead(state.head);
  return tracker;
}

}  // namespace estancia
