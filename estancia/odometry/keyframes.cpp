// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/rigid.hpp"

namespace estancia::odometry {
namespace {

constexpr int kLevels = 3;
constexpr int kFeatures = 800;
constexpr double kMinDepthShare = 0.02;  // share of the pixels; below, alignment is unreliable

}  // namespace

Choices alignmentTerms() {
  return {{"auto", "depth, and hybrid where depth alone is degenerate, as along a bare wall"},
          {"depth", "point-to-plane distances: the most exact where depth and color are not registered"},
          {"color", "differences of gray values; needs texture"},
          {"hybrid", "both"}};
}

AlignmentTerm alignmentTerm(const std::string& name) {
  requireChoice("term of odometry", name, alignmentTerms());
  if (name == "depth") return AlignmentTerm::depth;
  if (name == "color") return AlignmentTerm::color;
  return name == "hybrid" ? AlignmentTerm::hybrid : AlignmentTerm::automatic;
}

std::unique_ptr<FrameView> viewOf(const Sequence& sequence, std::size_t frame, const RgbdOptions& options) {
  auto view = std::make_unique<FrameView>();
  view->frame = frame;
  try {
    view->depth = sequence.depth(frame);
    view->bgr = sequence.image(frame);
    if (!sameShape(view->bgr.size(), view->depth.size()))
      fail(ErrorCode::mismatch,
           "depth has {} × {} pixels and the image {} × {}, so they show different views; export "
           "depth registered to color (see `estancia check`)",
           view->depth.cols, view->depth.rows, view->bgr.cols, view->bgr.rows);
    const CameraIntrinsics camera = sequence.intrinsics()->scaledTo(view->depth.cols, view->depth.rows);
    view->image = reducedImage(view->bgr, view->depth, camera, options.maxWidth, options.maxDepth);
    const int usable = cv::countNonZero(view->image.depth);
    if (usable < kMinDepthShare * static_cast<double>(view->image.depth.total()))
      view->problem =
          fmt::format("{} of {} pixels have depth up to {} m (see --depth-scale and `estancia check`)",
                      usable, view->image.depth.total(), options.maxDepth);
    else
      view->pyramid = pyramidOf(view->image, kLevels);
  } catch (...) {
    view->problem = frameFailure(sequence.frame(frame).name).what();
  }
  return view;
}

Keyframes::Keyframes(const RgbdOptions& options, const FrameWords& words)
    : options_(options), words_(words), recall_(words.parts) {
  alignment_.term = alignmentTerm(options.term);
}

const Pyramid& Keyframes::pyramid(std::size_t k) const {
  const auto found = std::ranges::find(cached_, k, &std::pair<std::size_t, Pyramid>::first);
  if (found != cached_.end()) {
    std::rotate(cached_.begin(), found, found + 1);
  } else {
    if (cached_.size() > 1) cached_.pop_back();
    cached_.insert(cached_.begin(), {k, pyramidOf(keyframes_[k].image, kLevels)});
  }
  return cached_.front().second;
}

Features Keyframes::featuresOf(const FrameView& view) const {
  return odometry::featuresOf(view.bgr, view.depth, view.image.camera, kFeatures, options_.maxDepth);
}

std::size_t Keyframes::add(const FrameView& view, const cv::Affine3d& pose) {
  keyframes_.push_back({view.frame, pose, view.image, featuresOf(view)});
  recall_.add(words_.describe ? words_.describe(view.frame) : LexicalDescriptor());
  return keyframes_.size() - 1;
}

void Keyframes::connect(std::size_t from, std::size_t to, const Alignment& alignment) {
  edges_.push_back({from, to, matrixOf(alignment.transform), alignment.information, false});
}

std::optional<cv::Affine3d> Keyframes::guess(const FrameView& view, std::size_t k) const {
  return guessFromFeatures(featuresOf(view), keyframes_[k].features, options_.minLoopFeatures);
}

std::vector<std::size_t> Keyframes::withSimilarWords(const FrameView& view) const {
  if (!words_.describe) return {};
  return recall_.nearest(recall_.embed(words_.describe(view.frame)),
                         static_cast<std::size_t>(options_.loopCandidates), [](std::size_t) { return true; });
}

std::optional<PoseGraphEdge> Keyframes::verified(std::size_t source, std::size_t target) const {
  const Keyframe &a = keyframes_[source], &b = keyframes_[target];
  const auto guess = guessFromFeatures(a.features, b.features, options_.minLoopFeatures);
  if (!guess) return std::nullopt;
  const Alignment found = align(pyramidOf(a.image, kLevels), pyramidOf(b.image, kLevels), *guess, alignment_);
  if (!found.solved || found.overlap < options_.minLoopOverlap || found.rmse > options_.maxRmse ||
      found.correlation < options_.minCorrelation)
    return std::nullopt;
  return PoseGraphEdge{source, target, matrixOf(found.transform), found.information, true};
}

void Keyframes::closeLoops(Progress& progress) {
  std::set<std::pair<std::size_t, std::size_t>> unique;
  const auto max = static_cast<std::size_t>(options_.loopCandidates),
             apart = static_cast<std::size_t>(options_.minLoopKeyframes);
  for (std::size_t k = 0; k < size(); ++k)
    for (const std::size_t other : recall_.nearest(
             recall_.embedded(k), max, [&](std::size_t o) { return o + apart <= k || k + apart <= o; }))
      unique.insert({std::max(k, other), std::min(k, other)});
  const std::vector<std::pair<std::size_t, std::size_t>> pairs(unique.begin(), unique.end());
  if (pairs.empty()) return;
  progress.begin("closing loops", pairs.size());
  std::vector<std::optional<PoseGraphEdge>> loops(pairs.size());
  inParallel(pairs.size(), options_.threads > 0 ? options_.threads : freeCores(), progress,
             "interrupted while closing loops; nothing was written, run odometry again",
             [&](std::size_t i) { loops[i] = verified(pairs[i].first, pairs[i].second); });
  progress.end();
  for (const auto& loop : loops)
    if (loop) edges_.push_back(*loop);
}

std::vector<std::pair<std::size_t, std::size_t>> Keyframes::optimize() {
  std::vector<std::pair<std::size_t, std::size_t>> accepted;
  if (std::ranges::none_of(edges_, &PoseGraphEdge::uncertain)) return accepted;
  std::vector<Matrix4> nodes;
  for (const Keyframe& k : keyframes_) nodes.push_back(matrixOf(k.pose));
  std::vector<bool> kept;
  if (!open3d().optimize(nodes, edges_, alignment_.sameSurface, kept)) return accepted;
  const cv::Affine3d back = keyframes_.front().pose * rigidOf(nodes.front()).inv();
  for (std::size_t k = 0; k < size(); ++k) keyframes_[k].pose = back * rigidOf(nodes[k]);
  for (std::size_t e = 0; e < edges_.size(); ++e)
    if (edges_[e].uncertain && kept[e]) accepted.emplace_back(edges_[e].source, edges_[e].target);
  return accepted;
}

}  // namespace estancia::odometry
