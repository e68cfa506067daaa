// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/thresholds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/stats/label_scale.hpp"

namespace estancia {
namespace {

constexpr std::size_t blockLength = 24;  // consecutive keyframes
constexpr std::size_t maxBlocks = 32;
constexpr std::size_t minBlocks = 8;     // blocks of a short run, which are shorter
constexpr std::size_t maxAnchors = 256;  // keyframes compared pair by pair: 32,640 pairs
constexpr std::size_t nearLag = 2;       // frames that count as near in time
constexpr std::size_t minGap = 5;        // frames that count as far in time, at least …
constexpr double gapShare = 0.05;        // … and this share of the run
constexpr std::size_t minFarPairs = 10;  // fewer give no useful quantile
constexpr double priorPairs = 2;         // the prior is as sure as a quantile of so many pairs of places
constexpr double minShare = 1e-4;        // τ_join stays above this share of its default, above mere rounding

/// Linear interpolation between order statistics (R's type 7). `values` is sorted.
double quantile(const std::vector<double>& values, double q) {
  const double position = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

Thresholds thresholdsFrom(double tauJoin, const ThresholdOptions& options) {
  return {tauJoin, options.revisitRatio * tauJoin, options.mergeRatio * tauJoin, 0.3 * tauJoin,
          0.5 * tauJoin};
}

ThresholdEstimator::ThresholdEstimator(Distance distance, std::size_t labels, ThresholdOptions options,
                                       LabelPrior prior)
    : distance_(std::move(distance)),
      options_(options),
      prior_(std::move(prior)),
      labels_(distance_, labels, prior_) {}

/// Every so many-th block is kept.
std::size_t ThresholdEstimator::strideAfter(std::size_t keyframes) {
  std::size_t stride = 1;
  while (keyframes > stride * maxBlocks * blockLength) stride *= 2;
  return stride;
}

bool ThresholdEstimator::add(std::span<const float> probabilities, std::span<const float> embedded) {
  const std::size_t frame = labels_.memory().frames;
  const std::size_t keyframe = labels_.memory().keyframes;
  if (!labels_.add(probabilities, embedded)) return false;
  const std::size_t stride = strideAfter(keyframe + 1);
  const auto isSpare = [stride](const auto& entry) { return entry.first / blockLength % stride != 0; };
  if (stride != strideAfter(keyframe)) {
    std::erase_if(sample_, isSpare);
    std::erase_if(sampled_, isSpare);
  }
  if (isSpare(std::pair(keyframe, frame))) return true;
  sample_.emplace(keyframe, std::vector<float>(embedded.begin(), embedded.end()));
  sampled_.emplace(keyframe, frame);
  return true;
}

Thresholds ThresholdEstimator::initial() const {
  return thresholdsFrom(distance_.standardized ? prior_.distanceAt(options_.farQuantile) : distance_.tauJoin,
                        options_);
}

std::optional<Thresholds> ThresholdEstimator::estimate(const Standardization& standardization) const {
  if (!labels_.hasSeenEnough()) return std::nullopt;
  Compared compared;  // just as frames and nodes will be
  for (const auto& [keyframe, embedded] : sample_)
    compared.emplace(keyframe, comparedVector(distance_, standardization, embedded));
  const std::optional<double> ofRun = tauOfRun(compared);
  if (!ofRun) return std::nullopt;
  double tauJoin = *ofRun;
  if (distance_.standardized) {
    const double spanned = placesSpanned(compared);
    // Weights of inverse variances: a quantile of so many pairs of places is off by about one of them.
    const double pairs = options_.farQuantile * spanned * (spanned + 1) / 2;
    const double own = pairs * pairs / (pairs * pairs + priorPairs * priorPairs);
    tauJoin = std::lerp(prior_.distanceAt(options_.farQuantile) * (1 + 1 / spanned), *ofRun, own);
  }
  return thresholdsFrom(std::max(tauJoin, minShare * distance_.tauJoin), options_);
}

/// τ from the run's own far pairs.
std::optional<double> ThresholdEstimator::tauOfRun(const Compared& compared) const {
  const auto distanceOf = [&](const std::vector<float>& a, const std::vector<float>& b) {
    return compare(distance_.comparison, a, b);
  };
  std::vector<double> near, far;
  const std::size_t every = (compared.size() + maxAnchors - 1) / maxAnchors;
  const auto gap = std::max(static_cast<double>(minGap), gapShare * static_cast<double>(keyframes()));
  for (const auto& [keyframe, vector] : compared) {
    if (keyframe % every != 0) continue;
    for (std::size_t lag = 1; lag <= nearLag; ++lag)
      if (const auto next = compared.find(keyframe + lag); next != compared.end())
        near.push_back(distanceOf(vector, next->second));
    for (auto other = compared.upper_bound(keyframe + static_cast<std::size_t>(gap)); other != compared.end();
         ++other)
      if (other->first % every == 0) far.push_back(distanceOf(vector, other->second));
  }
  if (far.size() < minFarPairs || near.empty()) return std::nullopt;
  std::sort(near.begin(), near.end());
  std::sort(far.begin(), far.end());
  const auto below = std::lower_bound(far.begin(), far.end(), quantile(near, 0.5)) - far.begin();
  const double revisited = std::min(0.8, 2.0 * static_cast<double>(below) / static_cast<double>(far.size()));
  return quantile(far, revisited + options_.farQuantile * (1 - revisited));
}

/// After how many keyframes two of them are half as similar as neighbors: the robot sees something else.
std::size_t ThresholdEstimator::changeLength(const Compared& compared) {
  double next = 0;
  for (std::size_t lag = 1; lag < blockLength; ++lag) {
    double sum = 0, pairs = 0;
    for (const auto& [keyframe, vector] : compared)
      if (const auto later = compared.find(keyframe + lag); later != compared.end()) {
        sum += dot(vector, later->second);
        ++pairs;
      }
    if (pairs == 0) return lag;
    if (lag == 1) next = sum / pairs;
    if (sum / pairs < next / 2) return lag;
  }
  return blockLength;
}

/// Participation ratio (Σ λ)²/Σ λ² = (tr G)²/tr G², where G are the products of the blocks' means: K − 1 for
/// K places, equally far from each other, about their mean.
double ThresholdEstimator::placesSpanned(const Compared& compared) const {
  const std::size_t length =
      std::clamp<std::size_t>(keyframes() / minBlocks, 1, std::min(2 * changeLength(compared), blockLength));
  std::map<std::size_t, std::vector<const std::vector<float>*>> blocks;
  for (const auto& [keyframe, vector] : compared) blocks[keyframe / length].push_back(&vector);
  std::vector<std::vector<float>> means;
  for (const auto& [block, members] : blocks) {
    if (2 * members.size() < length) continue;
    std::vector<float>& mean = means.emplace_back(members.front()->size(), 0.0F);
    for (const std::vector<float>* member : members)
      for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] += (*member)[i] / static_cast<float>(members.size());
  }
  double trace = 0, squares = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double square = dot(means[i], means[i]);
    trace += square;
    squares += square * square;
    for (std::size_t j = 0; j < i; ++j) squares += 2 * std::pow(dot(means[i], means[j]), 2);
  }
  return squares > 0 ? std::max(1.0, trace * trace / squares) : 1;
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
