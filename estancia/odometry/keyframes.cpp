// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframes.hpp"

#include <algorithm>

#include "estancia/core/error.hpp"
#include "estancia/stats/compared_vectors.hpp"

namespace estancia::odometry {
namespace {

constexpr std::size_t cacheSize = 8;
constexpr double minPrediction = 0.3;  // overlap; with less a keyframe helps little

}  // namespace

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
    if (cached_.size() >= cacheSize) cached_.pop_back();
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
    if (overlap >= minPrediction) found.emplace_back(-overlap, k);
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

}  // namespace estancia::odometry
