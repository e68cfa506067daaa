// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/tracker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/odometry/tracker_impl.hpp"

namespace estancia {
namespace {

using odometry::FrameView;
using odometry::isGood;
using odometry::times;
using odometry::TrackedFrame;
using EdgeKind = odometry::KeyframeGraph::Kind;

constexpr std::size_t longestBridge = 10;  // frames; the motion over more is unknown
constexpr double settled = 1e-6;           // [m]; smaller corrections are rounding errors

std::optional<double> finite(const std::optional<double>& timestamp) {
  return timestamp && std::isfinite(*timestamp) ? timestamp : std::nullopt;
}

odometry::AlignmentTerm termOf(const std::string& name) {
  using odometry::AlignmentTerm;
  if (name == "depth") return AlignmentTerm::depth;
  if (name == "color") return AlignmentTerm::color;
  return name == "hybrid" ? AlignmentTerm::hybrid : AlignmentTerm::automatic;
}

/// After which motion is not extrapolated.
bool isPause(double before, double now) {
  return std::abs(now - before) > 1;  // [s]
}

}  // namespace

RgbdTracker::Impl::Impl(const CameraIntrinsics& c, const RgbdOptions& chosen,
                        const std::vector<LabelPart>& parts)
    : camera(c), options(chosen), keyframes(parts) {
  validate(options);
  if (camera.width < 1 || camera.height < 1 || !(camera.fx > 0) || !(camera.fy > 0) ||
      !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy))
    fail(ErrorCode::invalidInput,
         "odometry needs the camera's intrinsics: width, height and focal lengths above 0; the size is {} × "
         "{}, the focal lengths are {} and {}",
         camera.width, camera.height, camera.fx, camera.fy);
  odometry::poseGraphOptimizer();  // rather than fail at the first keyframe that it is needed for
  how.term = termOf(options.term);
  threads = static_cast<std::size_t>(options.threads > 0 ? options.threads : usableCores());
}

/// T_map_frame, by the optimum of the pose graph.
cv::Affine3d RgbdTracker::Impl::trackedPose(std::size_t frame) const {
  return keyframes.pose(placed[frame]->keyframe) * rigidOf(placed[frame]->inKeyframe);
}

/// Last published pose; nothing for frames that are not in the map.
std::optional<cv::Affine3d> RgbdTracker::Impl::toldPose(std::size_t frame) const {
  if (!placed[frame]) return std::nullopt;
  const auto& keyframe = map.at(placed[frame]->keyframe);
  return keyframe ? std::optional(*keyframe * rigidOf(placed[frame]->inKeyframe)) : std::nullopt;
}

void RgbdTracker::Impl::hang(std::size_t frame, std::size_t keyframe, const cv::Affine3d& inKeyframe) {
  unhang(frame);
  placed[frame] = Placed{static_cast<std::uint32_t>(keyframe), poseOf(inKeyframe)};
  map.count(keyframe, 1);
}

void RgbdTracker::Impl::unhang(std::size_t frame) {
  changedFrames.insert(frame);
  if (placed[frame]) map.count(placed[frame]->keyframe, -1);
  placed[frame].reset();
}

std::size_t RgbdTracker::Impl::addKeyframe(Current& now, const cv::Affine3d& pose) {
  current = keyframes.add(now.frame, now.view, pose, now.words());
  changedKeyframes.insert(current);
  if (current > 0)
    if (const auto motion = prior.motion(keyframes[current - 1].frame, now.frame, options))
      graph.add({current, current - 1, motion->transform, motion->covariance}, EdgeKind::assumed);
  hang(now.frame, current, cv::Affine3d::Identity());
  return current;
}

void RgbdTracker::Impl::addTracked(Current& now, const Found& found) {
  const auto& [keyframe, alignment] = found;
  const std::size_t added = addKeyframe(now, alignment.transform);
  graph.add({added, keyframe, keyframes.pose(keyframe).inv() * alignment.transform,
             odometry::covarianceOf(alignment.information)},
            EdgeKind::tracked);
}

/// Stores the pose of the frame; one with little overlap becomes a keyframe.
void RgbdTracker::Impl::place(Current& now, const Found& found) {
  const auto& [keyframe, alignment] = found;
  if (alignment.overlap < options.keyframeOverlap) return addTracked(now, found);
  current = keyframe;
  hang(now.frame, keyframe, keyframes.pose(keyframe).inv() * alignment.transform);
}

/// Makes the last tracked frame a keyframe.
bool RgbdTracker::Impl::promoteLast() {
  if (keyframes[current].frame == lastFrame) return false;
  const auto found = refined(*last, lastPose, 0);
  if (!found || !isGood(found->alignment)) return false;
  Current before{lastFrame, *last, {}, LexicalDescriptor()};  // its words may be gone
  addTracked(before, *found);
  lastPose = found->alignment.transform;
  return true;
}

/// A keyframe where the motion so far would have led; loops correct it later.
void RgbdTracker::Impl::startAnew(Current& now) {
  constexpr double turn = 0.3, shift = 0.5;  // [rad], [m] of a motion that nothing measured
  const cv::Matx61d variances(turn * turn, turn * turn, turn * turn, shift * shift, shift * shift,
                              shift * shift);
  const cv::Affine3d pose = predicted(now.frame);
  std::size_t before = current;
  // One that no second frame could be aligned with is of no use: a camera in the dark shall not fill memory.
  const std::size_t k = keyframes.size() - 1;
  if (k > 0 && keyframes[k].frame == lastFrame && graph.isAlone(k)) {
    before = graph.referenceOf(k);
    unhang(lastFrame);
    graph.removeEdgesOf(k);
    keyframes.removeLast();
    map.removeLast();
  }
  const std::size_t added = addKeyframe(now, pose);
  graph.add({added, before, keyframes.pose(before).inv() * pose, cv::Matx66d::diag(variances)},
            EdgeKind::assumed);
}

void RgbdTracker::Impl::sayGap(const FrameFacts& facts, std::size_t frame) {
  const auto now = finite(facts.timestamp);
  if (!lastTime || !now || !isPause(*lastTime, *now)) return;
  velocity = cv::Affine3d::Identity();
  const std::string name = facts.name.empty() ? fmt::format("frame {}", frame) : facts.name;
  notes[frame] = *now < *lastTime
                     ? fmt::format("time stamps go back by {:.1f} s before {}", *lastTime - *now, name)
                     : fmt::format("{:.1f} s without {} before {}", *now - *lastTime,
                                   lastFrame + 1 == frame ? "an image" : "usable depth", name);
}

void RgbdTracker::Impl::begin(const FrameFacts& facts) {
  const std::size_t frame = placed.size();
  placed.emplace_back();
  changedFrames.insert(frame);
  if (!facts.prior) return;
  const auto now = finite(facts.timestamp);
  const bool paused = now && priorTime && isPause(*priorTime, *now);
  prior.add(frame, facts.prior, paused);
  if (prior.at(frame)) priorTime = now;
}

void RgbdTracker::Impl::track(const View& view, const FrameFacts& facts) {
  const std::size_t frame = placed.size() - 1, keyframesBefore = keyframes.size();
  if (!view->problem.empty()) {  // the camera is not lost: tracking continues with the next frame
    problems[frame] = view->problem;
    return;
  }
  Current now{frame, *view, facts};
  bool isSteady = false, isAnew = false;
  if (keyframes.size() == 0) {
    addKeyframe(now, rigidOf(Pose::planar(0, 0, 0)));
  } else {
    if (!isCarried) sayGap(facts, frame);
    auto found = isCarried ? std::nullopt : fit(*view, frame);
    if (!found && !isCarried && promoteLast()) found = fit(*view, frame);
    isCarried = false;
    isSteady = found.has_value();
    if (!found) found = relocalize(now);
    isAnew = !found;
    found ? place(now, *found) : startAnew(now);
  }
  const cv::Affine3d pose = trackedPose(frame);
  velocity = isSteady ? times(lastPose.inv() * pose, 1 / static_cast<double>(frame - lastFrame))
                      : cv::Affine3d::Identity();
  // A part of its own was just compared with all: nothing fits.
  if (!isAnew)
    for (std::size_t k = std::max<std::size_t>(keyframesBefore, 1); k < keyframes.size(); ++k) closeLoops(k);
  if (keyframes.size() != keyframesBefore || isAnew || map.isOutgrown())
    map.update(keyframes, graph, options.minCorrection);
  lastPose = trackedPose(frame);
  last = view, lastFrame = frame, lastTime = finite(facts.timestamp);
}

std::string RgbdTracker::Impl::problemOf(std::size_t frame) const {
  const auto problem = problems.find(frame);
  return problem == problems.end() ? "it fits no keyframe, or shows nothing to hold on to" : problem->second;
}

RgbdTracker::Placement RgbdTracker::Impl::at(std::size_t frame) const {
  if (const auto pose = toldPose(frame)) return {poseOf(*pose), ""};
  // Several frames that fit each other, but not the map, were taken elsewhere.
  const bool isElsewhere = placed[frame] && map.framesOfPartOf(placed[frame]->keyframe) > 1;
  const bool hasPrior = prior.at(frame).has_value();
  if (isElsewhere && !hasPrior) return {std::nullopt, problemOf(frame)};
  const std::size_t reach = hasPrior ? placed.size() : longestBridge;
  std::optional<TrackedFrame> before, after;
  for (std::size_t i = frame; i-- > 0 && frame - i <= reach && !before;)
    if (const auto pose = toldPose(i)) before = {i, *pose};
  for (std::size_t i = frame + 1; i < placed.size() && i - frame <= reach && !after; ++i)
    if (const auto pose = toldPose(i)) after = {i, *pose};
  if (before && after && !hasPrior && after->frame - before->frame > longestBridge + 1) after.reset();
  const auto pose = odometry::bridged(frame, before, after, prior);
  return {pose ? std::optional(poseOf(*pose)) : std::nullopt, problemOf(frame)};
}

RgbdTracker::RgbdTracker(const CameraIntrinsics& camera, const RgbdOptions& options,
                         const std::vector<LabelPart>& parts)
    : impl_(std::make_unique<Impl>(camera, options, parts)) {}
RgbdTracker::RgbdTracker(RgbdTracker&&) noexcept = default;
RgbdTracker& RgbdTracker::operator=(RgbdTracker&&) noexcept = default;
RgbdTracker::~RgbdTracker() = default;

RgbdTracker::View RgbdTracker::prepare(const cv::Mat& image, const cv::Mat& depth,
                                       const std::string& name) const {
  return std::make_shared<const FrameView>(
      odometry::viewOf(image, depth, impl_->camera, impl_->options, name));
}

void RgbdTracker::beginDrive() {
  impl_->isCarried = size() > 0;
  impl_->velocity = cv::Affine3d::Identity();
}

RgbdTracker::Placement RgbdTracker::add(const View& view, const FrameFacts& facts) {
  impl_->begin(facts);
  impl_->track(view, facts);
  impl_->online.resize(size());
  Placement placement = at(size() - 1);
  impl_->online.back() = placement.pose;
  return placement;
}

RgbdTracker::Placement RgbdTracker::add(const cv::Mat& image, const cv::Mat& depth, const FrameFacts& facts) {
  return add(prepare(image, depth, facts.name), facts);
}

RgbdTracker::Placement RgbdTracker::skip(const std::string& why, const FrameFacts& facts) {
  FrameView view;
  view.problem = why;
  return add(std::make_shared<const FrameView>(std::move(view)), facts);
}

std::size_t RgbdTracker::size() const {
  return impl_->placed.size();
}

RgbdTracker::Placement RgbdTracker::at(std::size_t frame) const {
  if (frame >= size())
    fail(ErrorCode::invalidInput, "frame {} is asked for, and {} were tracked", frame, size());
  return impl_->at(frame);
}

std::optional<Pose> RgbdTracker::motion(std::size_t from, std::size_t to) const {
  const Impl& impl = *impl_;
  if (from >= size() || to >= size() || !impl.placed[from] || !impl.placed[to] ||
      !impl.map.areJoined(impl.placed[from]->keyframe, impl.placed[to]->keyframe))
    return std::nullopt;
  return poseOf(impl.trackedPose(from).inv() * impl.trackedPose(to));
}

std::uint64_t RgbdTracker::revision() const {
  return impl_->map.revision();
}

void RgbdTracker::settle() {
  if (impl_->keyframes.size() > 0) impl_->map.update(impl_->keyframes, impl_->graph, settled);
}

RgbdTrajectory RgbdTracker::trajectory() const {
  const Impl& impl = *impl_;
  RgbdTrajectory result;
  for (std::size_t i = 0; i < size(); ++i) {
    const Placement placement = impl.at(i);
    result.poses.push_back(placement.pose);
    if (!placement.why.empty()) (placement.pose ? result.bridged : result.lost).push_back({i, placement.why});
  }
  for (std::size_t k = 0; k < impl.keyframes.size(); ++k) result.keyframes.push_back(impl.keyframes[k].frame);
  for (const auto& edge : impl.graph.edges())
    if (edge.kind == EdgeKind::loop && impl.graph.isSeen(edge) &&
        edge.source - edge.target >= odometry::minLoopKeyframes)
      result.loops.emplace_back(impl.keyframes[edge.source].frame, impl.keyframes[edge.target].frame);
  for (const auto& [frame, note] : impl.notes) result.notes.push_back(note);
  result.online = impl.online;
  result.online.resize(size());
  result.corrections = revision();
  return result;
}

}  // namespace estancia
