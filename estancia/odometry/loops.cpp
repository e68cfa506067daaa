// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/loops.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/rigid.hpp"

namespace estancia::odometry {
namespace {

constexpr double kMaxSpread = 0.1;  // [m]; an alignment that leaves more open holds on to nothing
constexpr int kRounds = 2;
constexpr double kMaxOff = 6;  // standard deviations; an edge that is off by more is an outlier

/// The later keyframe, and the earlier.
using Pair = std::pair<std::size_t, std::size_t>;

class LoopCloser {
 public:
  LoopCloser(Keyframes& keyframes, const std::vector<PoseGraphEdge>& tracked,
             const std::vector<PoseGraphEdge>& assumed, const RgbdOptions& options)
      : keyframes_(keyframes), others_(tracked), options_(options) {
    others_.insert(others_.end(), assumed.begin(), assumed.end());
    for (const PoseGraphEdge& edge : tracked)
      known_.insert({std::max(edge.source, edge.target), std::min(edge.source, edge.target)});
  }

  std::vector<Pair> predicted() const;
  std::vector<Pair> alike() const;
  void verify(const std::vector<Pair>& pairs, bool byPose, Progress& progress);
  void optimize();
  std::vector<PoseGraphEdge> agreed() const;

 private:
  std::optional<PoseGraphEdge> verified(const Pair& pair, bool byPose) const;

  Keyframes& keyframes_;
  std::vector<PoseGraphEdge> others_;  ///< tracked or assumed
  const RgbdOptions& options_;
  std::set<Pair> known_;  ///< connected
  std::vector<PoseGraphEdge> loops_;
  std::vector<double> off_;  ///< of loops_ [standard deviations]
};

/// Pairs that overlap where they are now, of each keyframe those that overlap most.
std::vector<Pair> LoopCloser::predicted() const {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    std::vector<std::pair<double, Pair>> found;
    for (std::size_t o = 0; o < k; ++o) {
      if (known_.contains({k, o})) continue;
      const cv::Affine3d motion = keyframes_.pose(o).inv() * keyframes_.pose(k);
      if (cv::norm(motion.translation()) > options_.maxDepth) continue;
      const double overlap = predictedOverlap(keyframes_[k].coarse, keyframes_[o].coarse, motion);
      if (overlap >= options_.minLoopOverlap) found.push_back({-overlap, {k, o}});
    }
    std::ranges::sort(found);
    for (std::size_t i = 0; i < found.size() && i < static_cast<std::size_t>(options_.loopCandidates); ++i)
      pairs.push_back(found[i].second);
  }
  return pairs;
}

/// Pairs with similar words.
std::vector<Pair> LoopCloser::alike() const {
  std::set<Pair> pairs;
  for (std::size_t k = 0; k < keyframes_.size(); ++k)
    for (const std::size_t other :
         keyframes_.withWordsOf(k, static_cast<std::size_t>(options_.minLoopKeyframes)))
      if (const Pair pair{std::max(k, other), std::min(k, other)}; !known_.contains(pair)) pairs.insert(pair);
  return {pairs.begin(), pairs.end()};
}

std::optional<PoseGraphEdge> LoopCloser::verified(const Pair& pair, bool byPose) const {
  const Keyframe &a = keyframes_[pair.first], &b = keyframes_[pair.second];
  std::optional<cv::Affine3d> guess = b.pose.inv() * a.pose;
  if (!byPose) guess = guessFromFeatures(a.features, b.features, options_.minLoopFeatures);
  if (!guess) return std::nullopt;
  const Pyramid source = keyframes_.newPyramid(pair.first), target = keyframes_.newPyramid(pair.second);
  const AlignmentTarget single{&target, cv::Affine3d::Identity()};
  AlignmentOptions how;
  how.term = alignmentTerm(options_.term);
  const Alignment found = align(source, {&single, 1}, *guess, how);
  if (!isGood(found, options_.minLoopOverlap, options_)) return std::nullopt;
  return PoseGraphEdge{pair.first, pair.second, found.transform, covarianceOf(found.information)};
}

void LoopCloser::verify(const std::vector<Pair>& pairs, bool byPose, Progress& progress) {
  std::vector<std::optional<PoseGraphEdge>> found(pairs.size());
  inParallel(pairs.size(), options_.threads > 0 ? options_.threads : freeCores(), progress,
             "interrupted while closing loops; nothing was written, run odometry again",
             [&](std::size_t i) { found[i] = verified(pairs[i], byPose); });
  for (const auto& edge : found)
    if (edge && known_.insert({edge->source, edge->target}).second) loops_.push_back(*edge);
}

void LoopCloser::optimize() {
  std::vector<PoseGraphEdge> edges = others_;
  edges.insert(edges.end(), loops_.begin(), loops_.end());
  std::vector<cv::Affine3d> poses;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) poses.push_back(keyframes_.pose(k));
  const std::vector<double> off = optimizePoses(poses, edges);
  off_.assign(off.end() - static_cast<std::ptrdiff_t>(loops_.size()), off.end());
  for (std::size_t k = 0; k < keyframes_.size(); ++k) keyframes_.move(k, poses[k]);
}

std::vector<PoseGraphEdge> LoopCloser::agreed() const {
  std::vector<PoseGraphEdge> edges;
  for (std::size_t i = 0; i < loops_.size(); ++i)
    if (off_[i] <= kMaxOff) edges.push_back(loops_[i]);
  return edges;
}

}  // namespace

bool isGood(const Alignment& a, double minOverlap, const RgbdOptions& options) {
  return a.solved && a.overlap >= minOverlap && a.rmse <= options.maxRmse &&
         a.correlation >= options.minCorrelation && a.spread <= kMaxSpread;
}

std::vector<std::size_t> partsOf(std::size_t nodes, const std::vector<PoseGraphEdge>& edges) {
  std::vector<std::size_t> part(nodes);
  std::iota(part.begin(), part.end(), 0);
  for (const PoseGraphEdge& edge : edges) {
    const std::size_t from = std::max(part[edge.source], part[edge.target]),
                      to = std::min(part[edge.source], part[edge.target]);
    std::ranges::replace(part, from, to);
  }
  return part;
}

std::vector<PoseGraphEdge> closeLoops(Keyframes& keyframes, const std::vector<PoseGraphEdge>& tracked,
                                      const std::vector<PoseGraphEdge>& assumed, const RgbdOptions& options,
                                      Progress& progress) {
  LoopCloser closer(keyframes, tracked, assumed, options);
  for (int round = 0; round < kRounds; ++round) {
    if (options.loopCandidates == 0) break;
    const auto alike = round == 0 ? closer.alike() : std::vector<Pair>();
    const auto predicted = closer.predicted();
    if (alike.empty() && predicted.empty()) break;
    progress.begin("closing loops", alike.size() + predicted.size());
    closer.verify(alike, false, progress);
    closer.verify(predicted, true, progress);
    progress.end();
    closer.optimize();
  }
  if (options.loopCandidates == 0) closer.optimize();
  return closer.agreed();
}

}  // namespace estancia::odometry
