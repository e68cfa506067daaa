// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframe_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia::odometry {

std::vector<std::size_t> smallest(std::vector<std::pair<double, std::size_t>> numbered, std::size_t max) {
  max = std::min(max, numbered.size());
  std::partial_sort(numbered.begin(), numbered.begin() + static_cast<std::ptrdiff_t>(max), numbered.end());
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < max; ++i) numbers.push_back(numbered[i].second);
  return numbers;
}

const Pyramid& Keyframes::pyramid(std::size_t k) const {
  const auto found = std::ranges::find_if(cached_, [&](const auto& cached) { return cached.first == k; });
  if (found != cached_.end()) {
    std::rotate(cached_.begin(), found, found + 1);
  } else {
    if (cached_.size() >= 8) cached_.pop_back();
    cached_.emplace(cached_.begin(), k, std::make_unique<const Pyramid>(newPyramid(k)));
  }
  return *cached_.front().second;
}

std::vector<float> Keyframes::embedded(const LexicalDescriptor& words) const {
  std::vector<float> embedded(words.size());
  if (!words.empty()) embed(distance_.embedding, words, embedded, distance_.parts);
  return embedded;
}

void Keyframes::countWords(const std::vector<float>& words) {
  if (words.empty()) return;
  if (!moments_) moments_.emplace(words.size(), true);
  if (words.size() != moments_->mean().size())
    throw Error(ErrorCode::mismatch,
                "the number of labels changed between frames; label the sequence first (estancia label)");
  moments_->add(words);
}

std::size_t Keyframes::add(std::size_t frame, const FrameView& view, const cv::Affine3d& pose,
                           const LexicalDescriptor& words) {
  Keyframe keyframe{frame, pose, view.image, coarseOf(view.pyramid), view.features, embedded(words)};
  countWords(keyframe.words);
  keyframes_.push_back(std::move(keyframe));
  return keyframes_.size() - 1;
}

void Keyframes::removeLast() {
  keyframes_.pop_back();
  moments_.reset();  // summed up anew, so that they do not depend on what is gone
  for (const Keyframe& keyframe : keyframes_) countWords(keyframe.words);
  std::erase_if(cached_, [&](const auto& cached) { return cached.first == size(); });
}

std::vector<std::size_t> Keyframes::overlapped(const CoarseView& view, const cv::Affine3d& pose,
                                               std::span<const std::size_t> candidates,
                                               std::size_t max) const {
  std::vector<std::pair<double, std::size_t>> found;
  for (const std::size_t k : candidates) {
    const double overlap = predictedOverlap(view, keyframes_[k].coarse, keyframes_[k].pose.inv() * pose);
    if (overlap >= 0.3) found.emplace_back(-overlap, k);  // with less a keyframe helps little
  }
  return smallest(std::move(found), max);
}

std::vector<std::size_t> Keyframes::nearest(const std::vector<float>& words, std::size_t max,
                                            const std::function<bool(std::size_t)>& eligible) const {
  if (words.empty() || !moments_ || words.size() != moments_->mean().size()) return {};
  const Standardization run = standardizationBy(*moments_);
  const std::vector<float> sought = comparedVector(distance_, run, words);
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t k = 0; k < size(); ++k)
    if (const auto& theirs = keyframes_[k].words; !theirs.empty() && eligible(k))
      found.emplace_back(compare(distance_.comparison, sought, comparedVector(distance_, run, theirs)), k);
  return smallest(std::move(found), max);
}

std::vector<std::size_t> Keyframes::withWords(const LexicalDescriptor& words, std::size_t max) const {
  return nearest(embedded(words), max, [](std::size_t) { return true; });
}

std::vector<std::size_t> Keyframes::withWordsOf(std::size_t k, std::size_t apart, std::size_t max) const {
  return nearest(keyframes_[k].words, max, [&](std::size_t o) { return o + apart <= k; });
}

void Keyframes::write(std::size_t k, ByteWriter& bytes) const {
  const Keyframe& keyframe = keyframes_[k];
  bytes.number(static_cast<std::uint64_t>(keyframe.frame));
  odometry::write(keyframe.image, bytes);
  odometry::write(keyframe.features, bytes);
  bytes.numbers(keyframe.words);
}

void Keyframes::read(ByteReader& bytes) {
  Keyframe keyframe;
  keyframe.frame = bytes.number<std::uint64_t>();
  keyframe.image = readPackedImage(bytes);
  keyframe.coarse = coarseOf(pyramidOf(keyframe.image));
  keyframe.features = readFeatures(bytes);
  keyframe.words = bytes.numbers<float>();
  countWords(keyframe.words);
  keyframes_.push_back(std::move(keyframe));
}

bool isGood(const Alignment& a, double minOverlap) {
  // 3 cm of difference in depth; and gray values correlate, since bare walls have the same shape everywhere.
  return a.solved && a.overlap >= minOverlap && a.rmse <= 0.03 && a.correlation >= 0.5 &&
         a.spread <= 0.1;  // [m]; an alignment that leaves more open holds on to nothing
}

bool KeyframeGraph::isSeen(const Edge& edge) {
  // A loop that is off by more than 6 standard deviations is an outlier.
  return edge.kind == Kind::tracked || (edge.kind == Kind::loop && edge.off <= 6);
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
  constexpr std::size_t window = 64;  // keyframes that are optimized at once, in 50 ms
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

void MapPoses::count(std::size_t k, std::ptrdiff_t frames) {
  frames_.resize(std::max(frames_.size(), k + 1));
  frames_[k] += static_cast<std::size_t>(frames);
  if (k >= part_.size()) return;
  partFrames_[part_[k]] += static_cast<std::size_t>(frames);
  outgrown_ = outgrown_ || partFrames_[part_[k]] > partFrames_[map_];
}

void MapPoses::countParts(const KeyframeGraph& graph, std::size_t keyframes) {
  part_ = graph.parts(keyframes);
  frames_.resize(keyframes);
  partFrames_.assign(keyframes, 0);
  for (std::size_t k = 0; k < keyframes; ++k) partFrames_[part_[k]] += frames_[k];
}

void MapPoses::update(const Keyframes& keyframes, const KeyframeGraph& graph, double tolerance) {
  countParts(graph, keyframes.size());
  outgrown_ = false;
  const auto map = static_cast<std::size_t>(std::ranges::max_element(partFrames_) - partFrames_.begin());
  // The part's first camera is the origin.
  const cv::Affine3d toMap = rigidOf(Pose::planar(0, 0, 0)) * keyframes.pose(map).inv();
  std::vector<std::optional<cv::Affine3d>> best(keyframes.size());
  for (std::size_t k = 0; k < best.size(); ++k)
    if (part_[k] == map) best[k] = toMap * keyframes.pose(k);

  const auto isCorrected = [&](std::size_t k) {
    if (!best[k] || !told_[k]) return best[k].has_value() != told_[k].has_value();
    return shiftOfScene(told_[k]->inv() * *best[k], keyframes[k].coarse) > tolerance;
  };
  bool corrected = false;
  for (std::size_t k = 0; k < told_.size() && !corrected; ++k) corrected = isCorrected(k);
  map_ = map;
  if (corrected || told_.empty()) {
    revision_ += corrected ? 1 : 0;
    told_ = std::move(best);
    return;
  }
  for (std::size_t k = told_.size(); k < best.size(); ++k) {
    told_.emplace_back();
    if (!best[k]) continue;
    const std::size_t from = graph.referenceOf(k);
    told_[k] = *told_[from] * (keyframes.pose(from).inv() * keyframes.pose(k));
  }
}

void MapPoses::removeLast() {
  told_.pop_back();
  frames_.pop_back();
  part_.pop_back();
  partFrames_.pop_back();
}

void MapPoses::write(ByteWriter& bytes) const {
  bytes.number(revision_);
  bytes.number(static_cast<std::uint64_t>(map_));
  bytes.number(static_cast<std::uint64_t>(told_.size()));
  for (const auto& pose : told_) {
    bytes.number(static_cast<std::uint8_t>(pose ? 1 : 0));
    if (pose) odometry::write(*pose, bytes);
  }
}

void MapPoses::read(const KeyframeGraph& graph, std::vector<std::size_t> framesOf, ByteReader& bytes) {
  frames_ = std::move(framesOf);
  revision_ = bytes.number<std::uint64_t>();
  map_ = bytes.number<std::uint64_t>();
  if (bytes.count(1) != frames_.size() || (map_ >= frames_.size() && !frames_.empty()))
    bytes.fail("it has not a pose for every keyframe");
  for (std::size_t k = 0; k < frames_.size(); ++k)
    told_.push_back(bytes.number<std::uint8_t>() != 0 ? std::optional(readTransform(bytes)) : std::nullopt);
  countParts(graph, frames_.size());
}

}  // namespace estancia::odometry
