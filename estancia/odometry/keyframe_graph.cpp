// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframe_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace estancia::odometry {
namespace {

constexpr double maxSpread = 0.1;   // [m]; an alignment that leaves more open holds on to nothing
constexpr double maxOff = 6;        // standard deviations; a loop that is off by more is an outlier
constexpr std::size_t window = 64;  // keyframes that are optimized at once, in 50 ms

}  // namespace

bool isGood(const Alignment& a, double minOverlap) {
  // 3 cm of difference in depth; and gray values correlate, since bare walls have the same shape everywhere.
  return a.solved && a.overlap >= minOverlap && a.rmse <= 0.03 && a.correlation >= 0.5 &&
         a.spread <= maxSpread;
}

bool KeyframeGraph::isSeen(const Edge& edge) {
  return edge.kind == Kind::tracked || (edge.kind == Kind::loop && edge.off <= maxOff);
}

void KeyframeGraph::add(const PoseGraphEdge& edge, Kind kind) {
  ofNode_.resize(std::max(ofNode_.size(), edge.source + 1));
  ofNode_[edge.source].push_back(edges_.size());
  ofNode_[edge.target].push_back(edges_.size());
  if (kind != Kind::assumed) aligned_.insert({edge.source, edge.target});
  edges_.push_back({edge, kind, 0});
}

void KeyframeGraph::removeEdgesOf(std::size_t keyframe) {
  while (!edges_.empty() && edges_.back().source == keyframe) {
    ofNode_[edges_.back().target].pop_back();
    aligned_.erase({keyframe, edges_.back().target});
    edges_.pop_back();
  }
  if (keyframe < ofNode_.size()) ofNode_.resize(keyframe);
}

std::size_t KeyframeGraph::referenceOf(std::size_t k) const {
  std::size_t reference = 0;
  for (const std::size_t e : ofNode_.at(k))
    if (edges_[e].source == k && edges_[e].kind != Kind::loop) reference = edges_[e].target;
  return reference;
}

bool KeyframeGraph::isAlone(std::size_t k) const {
  return std::ranges::all_of(ofNode_.at(k), [&](std::size_t e) { return edges_[e].kind == Kind::assumed; });
}

bool KeyframeGraph::isOverdetermined(std::size_t k) const {
  return std::ranges::count(ofNode_.at(k), k, [&](std::size_t e) { return edges_[e].source; }) > 1;
}

/// The latest keyframe and those around it; all, when one of its edges leads elsewhere.
std::vector<bool> KeyframeGraph::toMove(std::size_t keyframes) const {
  std::vector<bool> all(keyframes, true), near(keyframes);
  if (keyframes <= window) return all;
  const std::size_t latest = keyframes - 1, reference = referenceOf(latest);
  near[latest] = near[reference] = true;
  for (const std::size_t k : around(reference, window, keyframes, latest)) near[k] = true;
  for (const std::size_t e : ofNode_.at(latest))
    if (!near[edges_[e].target]) return all;
  return near;
}

void KeyframeGraph::optimize(Keyframes& keyframes) {
  std::vector<cv::Affine3d> poses;
  for (std::size_t k = 0; k < keyframes.size(); ++k) poses.push_back(keyframes.pose(k));
  const std::vector<bool> free = toMove(keyframes.size());
  std::vector<PoseGraphEdge> edges;
  std::vector<std::size_t> numbers;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (!free[edges_[e].source] && !free[edges_[e].target]) continue;
    edges.push_back(edges_[e]);
    numbers.push_back(e);
  }
  const std::vector<double> off = optimizePoses(poses, edges, free);
  for (std::size_t i = 0; i < numbers.size(); ++i) edges_[numbers[i]].off = off[i];
  for (std::size_t k = 0; k < keyframes.size(); ++k) keyframes.move(k, poses[k]);
}

std::vector<std::size_t> KeyframeGraph::around(std::size_t k, std::size_t max, std::size_t reach,
                                               std::optional<std::size_t> without) const {
  std::vector<std::size_t> found{k};
  std::vector<bool> isFound(ofNode_.size());
  if (k < isFound.size()) isFound[k] = true;
  if (without) isFound.at(*without) = true;
  std::size_t first = 0;
  for (; reach > 0 && first < found.size(); --reach)
    for (const std::size_t last = found.size(); first < last; ++first) {
      const std::size_t node = found[first];
      for (std::size_t i = node < ofNode_.size() ? ofNode_[node].size() : 0; i-- > 0;) {
        const Edge& edge = edges_[ofNode_[node][i]];
        const std::size_t other = edge.source == node ? edge.target : edge.source;
        if (isFound[other] || !(isSeen(edge) || edge.kind == Kind::assumed)) continue;
        isFound[other] = true;
        found.push_back(other);
        if (found.size() > max) return {found.begin() + 1, found.end()};
      }
    }
  return {found.begin() + 1, found.end()};
}

std::vector<std::size_t> KeyframeGraph::parts(std::size_t keyframes) const {
  std::vector<std::size_t> part(keyframes);
  std::iota(part.begin(), part.end(), 0);
  const auto rootOf = [&](std::size_t k) {
    while (part[k] != k) k = part[k] = part[part[k]];
    return k;
  };
  for (const Edge& edge : edges_) {
    if (!isSeen(edge)) continue;
    const std::size_t a = rootOf(edge.source), b = rootOf(edge.target);
    part[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t k = 0; k < keyframes; ++k) part[k] = rootOf(k);
  return part;
}

void KeyframeGraph::write(std::size_t k, ByteWriter& bytes) const {
  std::vector<const Edge*> own;
  for (const std::size_t e : k < ofNode_.size() ? ofNode_[k] : std::vector<std::size_t>())
    if (edges_[e].source == k) own.push_back(&edges_[e]);
  bytes.number(static_cast<std::uint64_t>(own.size()));
  for (const Edge* edge : own) {
    bytes.number(static_cast<std::uint64_t>(edge->target));
    bytes.number(static_cast<std::uint8_t>(edge->kind));
    odometry::write(edge->transform, bytes);
    for (const double value : edge->covariance.val) bytes.number(value);
  }
}

void KeyframeGraph::read(std::size_t k, ByteReader& bytes) {
  const std::size_t count = bytes.count(9 + (16 + 36) * sizeof(double));
  for (std::size_t i = 0; i < count; ++i) {
    PoseGraphEdge edge;
    edge.source = k, edge.target = bytes.number<std::uint64_t>();
    const auto kind = bytes.number<std::uint8_t>();
    edge.transform = readTransform(bytes);
    for (double& value : edge.covariance.val) value = bytes.number<double>();
    if (edge.target >= k || kind > static_cast<std::uint8_t>(Kind::assumed) ||
        !std::isfinite(cv::norm(edge.covariance)))
      bytes.fail("an edge of its pose graph is damaged");
    add(edge, static_cast<Kind>(kind));
  }
}

void write(const cv::Affine3d& transform, ByteWriter& bytes) {
  for (const double value : transform.matrix.val) bytes.number(value);
}

cv::Affine3d readTransform(ByteReader& bytes) {
  cv::Affine3d transform;
  for (double& value : transform.matrix.val) value = bytes.number<double>();
  if (!std::isfinite(cv::norm(transform.matrix))) bytes.fail("a pose is not finite");
  return transform;
}

}  // namespace estancia::odometry
