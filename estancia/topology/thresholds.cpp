// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/thresholds.hpp"

#include <algorithm>
#include <utility>

#include "estancia/stats/compared_vectors.hpp"

namespace estancia {
namespace {

constexpr std::size_t anchors = 256;     // keyframes compared pair by pair: 32,640 pairs
constexpr std::size_t nearLag = 2;       // frames that count as near in time
constexpr std::size_t minGap = 5;        // frames that count as far in time, at least …
constexpr double gapShare = 0.05;        // … and this share of the run
constexpr std::size_t minFarPairs = 10;  // below this a quantile says nothing
constexpr double maxRevisitShare = 0.8;
constexpr double minShare = 1e-4;  // τ_join stays above this share of its default, above mere rounding

/// Linear interpolation between order statistics (R's type 7). `values` is sorted.
double quantile(const std::vector<double>& values, double q) {
  const double position = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

Thresholds thresholdsFrom(double tauJoin, const ThresholdOptions& options) {
  return {tauJoin, options.revisitRatio * tauJoin, options.mergeRatio * tauJoin, options.viewRatio * tauJoin,
          options.sequenceRatio * tauJoin};
}

ThresholdEstimator::ThresholdEstimator(Distance distance, std::size_t labels, ThresholdOptions options)
    : distance_(std::move(distance)), options_(options), labels_(distance_, labels) {}

std::size_t ThresholdEstimator::strideAfter(std::size_t keyframes) {
  std::size_t stride = 1;
  while ((keyframes + stride - 1) / stride > anchors) stride *= 2;
  return stride;
}

void ThresholdEstimator::add(std::span<const float> probabilities, std::span<const float> embedded) {
  const std::size_t frame = labels_.memory().frames;
  const std::size_t keyframe = labels_.memory().keyframes;
  if (!labels_.add(probabilities, embedded)) return;
  const std::size_t stride = strideAfter(keyframe + 1);
  if (stride != strideAfter(std::max<std::size_t>(keyframe, 1))) {
    const auto isSpare = [stride](const auto& entry) { return entry.first % stride > nearLag; };
    std::erase_if(sample_, isSpare);
    std::erase_if(sampled_, isSpare);
  }
  if (keyframe % stride > nearLag) return;
  sample_.emplace(keyframe, std::vector<float>(embedded.begin(), embedded.end()));
  sampled_.emplace(keyframe, frame);
}

std::optional<Thresholds> ThresholdEstimator::estimate(const Standardization& standardization) const {
  if (!labels_.hasSeenEnough()) return std::nullopt;
  // Pairs of frames are compared just as frames and nodes will be.
  std::map<std::size_t, std::vector<float>> compared;
  for (const auto& [frame, embedded] : sample_)
    compared.emplace(frame, comparedVector(distance_, standardization, embedded));
  const auto distanceOf = [&](const std::vector<float>& a, const std::vector<float>& b) {
    return compare(distance_.comparison, a, b);
  };

  std::vector<double> near, far;
  const std::size_t stride = strideAfter(keyframes());
  const auto gap = std::max(static_cast<double>(minGap), gapShare * static_cast<double>(keyframes()));
  for (const auto& [frame, vector] : compared) {
    if (frame % stride != 0) continue;
    for (std::size_t lag = 1; lag <= nearLag; ++lag)
      if (const auto next = compared.find(frame + lag); next != compared.end())
        near.push_back(distanceOf(vector, next->second));
    for (auto other = compared.upper_bound(frame + static_cast<std::size_t>(gap)); other != compared.end();
         ++other)
      if (other->first % stride == 0) far.push_back(distanceOf(vector, other->second));
  }
  if (far.size() < minFarPairs || near.empty()) return std::nullopt;
  std::sort(near.begin(), near.end());
  std::sort(far.begin(), far.end());
  const auto below = std::lower_bound(far.begin(), far.end(), quantile(near, 0.5)) - far.begin();
  const double revisited =
      std::min(maxRevisitShare, 2.0 * static_cast<double>(below) / static_cast<double>(far.size()));
  const double tauJoin = quantile(far, revisited + options_.farQuantile * (1 - revisited));
  return thresholdsFrom(std::max(tauJoin, minShare * distance_.tauJoin), options_);
}

ThresholdEstimator::Memory ThresholdEstimator::memory() const {
  return {labels_.memory(), sampled_};
}

void ThresholdEstimator::restore(Memory memory, Moments moments,
                                 const std::function<std::vector<float>(std::size_t)>& probabilities) {
  sampled_ = std::move(memory.sampled);
  for (const auto& [keyframe, frame] : sampled_) {
    std::vector<float> embedded = probabilities(frame);
    embed(distance_.embedding, embedded, embedded, distance_.parts);
    sample_.emplace(keyframe, std::move(embedded));
  }
  labels_.restore(memory, std::move(moments),
                  memory.frames > 0 ? probabilities(memory.lastView) : std::vector<float>{});
}

}  // namespace estancia
