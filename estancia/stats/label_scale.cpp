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
constexpr double priorKeyframes = 20;   // that a prior counts as; without one, centers shrink to 0 by them
constexpr double weightPrior = 1;       // keyframes that the labels' weights shrink by
constexpr double quietShare = 0.01;  // labels with less variance than this share of the typical one fade out

}  // namespace

/// Weight σ/(σ² + λ): about 1/σ for labels that vary. λ suppresses those that hardly vary, among them all
/// that never fire, and is larger while a run is short.
Standardization standardizationBy(const Moments& moments, const LabelPrior& prior) {
  const double n = moments.weight();
  const bool known = !prior.center.empty();
  const double own = n / (n + priorKeyframes);
  std::vector<float> center(moments.mean().begin(), moments.mean().end());
  std::vector<float> variance(moments.variance().begin(), moments.variance().end());
  for (std::size_t i = 0; i < center.size(); ++i) {
    center[i] = static_cast<float>(std::lerp(known ? prior.center[i] : 0.0, double{center[i]}, own));
    if (known)
      variance[i] = static_cast<float>(std::lerp(double{prior.variance[i]}, double{variance[i]}, own));
  }
  double sum = 0, squares = 0;
  for (const float v : variance) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double typical = sum > 0 ? squares / sum : 0;  // the variance of the labels that make up the variance
  const double lambda = typical * (quietShare + weightPrior / (n + weightPrior));
  Standardization result{std::move(center), std::vector<float>(variance.size(), 1.0F)};
  if (lambda > 0)
    for (std::size_t i = 0; i < variance.size(); ++i)
      result.weight[i] = static_cast<float>(std::sqrt(variance[i]) / (variance[i] + lambda));
  return result;
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
