// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframe_graph.hpp"

#include <algorithm>

#include "estancia/core/pose.hpp"

namespace estancia::odometry {
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
