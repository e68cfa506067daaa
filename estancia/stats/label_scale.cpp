// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_scale.hpp"

#include <cmath>
#include <utility>

namespace estancia {
namespace {

constexpr double novelty = 0.05;     // cosine distance of log-ratios beyond a standing camera's noise: about
                                     // .015, at most .04, against .15 and more between views of a moving one
constexpr std::size_t minViews = 3;  // fewer may be noise
constexpr std::size_t maxRepeats = 10;  // frames of one view that count
// keyframes that a prior counts as; without one, centers shrink to 0 by them
constexpr double priorKeyframes = 20;
constexpr double weightPrior = 1;    // keyframes that the labels' weights shrink by
constexpr double quietShare = 0.01;  // labels with less variance than this share of the typical one fade out

/// Spread of the labels, from a prior and the keyframes.
struct Spread {
  std::vector<float> center, variance;
  double keyframes = 0;
};

Spread spreadOf(const Moments& moments, const LabelPrior& prior) {
  const double n = moments.weight();
  const bool known = !prior.center.empty();
  const double own = n / (n + priorKeyframes);
  Spread spread{{moments.mean().begin(), moments.mean().end()},
                {moments.variance().begin(), moments.variance().end()},
                n};
  for (std::size_t i = 0; i < spread.center.size(); ++i) {
    float &center = spread.center[i], &variance = spread.variance[i];
    center = static_cast<float>(std::lerp(known ? prior.center[i] : 0.0, double{center}, own));
    if (known) variance = static_cast<float>(std::lerp(double{prior.variance[i]}, double{variance}, own));
  }
  return spread;
}

/// Weight σ/(σ² + λ): about 1/σ for labels that vary. λ suppresses those that hardly vary, among them all
/// that never fire, and is larger while a run is short.
Standardization standardizationBy(Spread spread) {
  double sum = 0, squares = 0;
  for (const float v : spread.variance) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double typical = sum > 0 ? squares / sum : 0;  // the variance of the labels that make up the variance
  const double lambda = typical * (quietShare + weightPrior / (spread.keyframes + weightPrior));
  Standardization result{std::move(spread.center), std::vector<float>(spread.variance.size(), 1.0F)};
  if (lambda > 0)
    for (std::size_t i = 0; i < spread.variance.size(); ++i)
      result.weight[i] = static_cast<float>(std::sqrt(spread.variance[i]) / (spread.variance[i] + lambda));
  return result;
}

}  // namespace

Standardization standardizationBy(const Moments& moments, const LabelPrior& prior) {
  return standardizationBy(spreadOf(moments, prior));
}

Standardization commonStandardization(const Moments& a, const Moments& b, const LabelPrior& prior) {
  Spread both = spreadOf(a, prior);
  const Spread other = spreadOf(b, prior);
  both.keyframes += other.keyframes;
  for (std::size_t i = 0; i < both.center.size(); ++i) {
    const float half = (both.center[i] - other.center[i]) / 2;
    both.center[i] -= half;
    both.variance[i] = (both.variance[i] + other.variance[i]) / 2 + half * half;
  }
  return standardizationBy(std::move(both));
}

LabelScale::LabelScale(Distance distance, std::size_t labels, LabelPrior prior)
    : distance_(std::move(distance)), labels_(labels), prior_(std::move(prior)), moments_(labels, true) {}

bool LabelScale::counts(std::span<const float> probabilities, std::span<const float> embedded) {
  std::vector<float> ratios(embedded.begin(), embedded.end());
  if (distance_.embedding != Embedding::centeredLogRatio)
    embed(Embedding::centeredLogRatio, probabilities, ratios, distance_.parts);
  if (lastView_.empty() || compare(Comparison::cosine, ratios, lastView_) > novelty) {
    lastView_ = std::move(ratios);
    memory_.lastView = memory_.frames - 1;
    memory_.repeats = 0;
    ++memory_.views;
    return true;
  }
  return ++memory_.repeats < maxRepeats;
}

bool LabelScale::add(std::span<const float> probabilities, std::span<const float> embedded) {
  ++memory_.frames;
  if (!counts(probabilities, embedded)) return false;
  ++memory_.keyframes;
  moments_.add(embedded);
  return true;
}

bool LabelScale::hasSeenEnough() const {
  return memory_.views >= minViews;
}

Standardization LabelScale::standardization() const {
  if (!distance_.standardized || memory_.frames == 0) return {};
  if (!hasSeenEnough() && prior_.center.empty())
    return {std::vector<float>(labels_, 0.0F), std::vector<float>(labels_, 1.0F)};
  return standardizationBy(moments_, prior_);
}

void LabelScale::restore(Memory memory, Moments moments, std::vector<float> lastView) {
  memory_ = memory;
  moments_ = std::move(moments);
  lastView_ = std::move(lastView);
  if (!lastView_.empty()) embed(Embedding::centeredLogRatio, lastView_, lastView_, distance_.parts);
}

}  // namespace estancia
