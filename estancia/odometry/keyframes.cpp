// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframes.hpp"

#include <algorithm>

namespace estancia::odometry {
namespace {

constexpr std::size_t cacheSize = 8;
constexpr double minPrediction = 0.3;  // overlap; with less a keyframe helps little

}  // namespace

Choices alignmentTerms() {
  return {{"auto", "depth and color, as if these were registered to each other within pixels only"},
          {"depth", "point-to-plane distances; nothing holds along a bare wall"},
          {"color", "differences of gray values; needs texture"},
          {"hybrid", "depth and color; needs both exactly registered"}};
}

AlignmentTerm alignmentTerm(const std::string& name) {
  requireChoice("term of odometry", name, alignmentTerms());
  if (name == "depth") return AlignmentTerm::depth;
  if (name == "color") return AlignmentTerm::color;
  return name == "hybrid" ? AlignmentTerm::hybrid : AlignmentTerm::automatic;
}

const Pyramid& Keyframes::pyramid(std::size_t k) const {
  const auto found = std::ranges::find_if(cached_, [&](const auto& cached) { return cached.first == k; });
  if (found != cached_.end()) {
    std::rotate(cached_.begin(), found, found + 1);
  } else {
    if (cached_.size() >= cacheSize) cached_.pop_back();
    cached_.emplace(cached_.begin(), k, std::make_unique<const Pyramid>(newPyramid(k)));
  }
  return *cached_.front().second;
}

std::size_t Keyframes::add(std::size_t frame, const FrameView& view, const cv::Affine3d& pose,
                           const LexicalDescriptor& words) {
  recall_.add(recall_.embed(words));
  keyframes_.push_back({frame, pose, view.image, coarseOf(view.pyramid), view.features});
  return keyframes_.size() - 1;
}

void Keyframes::removeLast() {
  keyframes_.pop_back();
  recall_.removeLast();
  std::erase_if(cached_, [&](const auto& cached) { return cached.first == size(); });
}

std::vector<std::size_t> Keyframes::overlapped(const CoarseView& view, const cv::Affine3d& pose,
                                               std::span<const std::size_t> candidates,
                                               std::size_t max) const {
  std::vector<std::pair<double, std::size_t>> found;
  for (const std::size_t k : candidates) {
    const double overlap = predictedOverlap(view, keyframes_[k].coarse, keyframes_[k].pose.inv() * pose);
    if (overlap >= minPrediction) found.emplace_back(-overlap, k);
  }
  std::ranges::sort(found);
  std::vector<std::size_t> keyframes;
  for (const auto& [overlap, k] : found)
    if (keyframes.size() < max) keyframes.push_back(k);
  return keyframes;
}

std::vector<std::size_t> Keyframes::withWords(const LexicalDescriptor& words, std::size_t max) const {
  if (words.empty()) return {};
  return recall_.nearest(recall_.embed(words), max, [](std::size_t) { return true; });
}

std::vector<std::size_t> Keyframes::withWordsOf(std::size_t k, std::size_t apart, std::size_t max) const {
  if (recall_.embedded(k).empty()) return {};
  return recall_.nearest(recall_.embedded(k), max, [&](std::size_t o) { return o + apart <= k; });
}

void Keyframes::write(std::size_t k, ByteWriter& bytes) const {
  const Keyframe& keyframe = keyframes_[k];
  bytes.number(static_cast<std::uint64_t>(keyframe.frame));
  odometry::write(keyframe.image, bytes);
  odometry::write(keyframe.features, bytes);
  bytes.numbers(recall_.embedded(k));
}

void Keyframes::read(ByteReader& bytes) {
  Keyframe keyframe;
  keyframe.frame = bytes.number<std::uint64_t>();
  keyframe.image = readPackedImage(bytes);
  keyframe.coarse = coarseOf(pyramidOf(keyframe.image));
  keyframe.features = readFeatures(bytes);
  recall_.add(bytes.numbers<float>());
  keyframes_.push_back(std::move(keyframe));
}

}  // namespace estancia::odometry
