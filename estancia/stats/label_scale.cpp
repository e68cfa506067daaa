// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_scale.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace estancia {
namespace {

/// Spread of the labels, from a prior and the keyframes.
struct Spread {
  std::vector<float> center, variance;
  double keyframes = 0;
};

Spread spreadOf(const Moments& moments, const LabelPrior& prior) {
  const double n = moments.weight();
  const bool known = !prior.center.empty();
  const double own = n / (n + 20);  // a prior counts as 20 keyframes; without one, centers shrink to 0
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
  // Labels with less than 1 % of that fade out; the weights shrink by one keyframe.
  const double lambda = typical * (0.01 + 1 / (spread.keyframes + 1));
  Standardization result{std::move(spread.center), std::vector<float>(spread.variance.size(), 1.0F)};
  if (lambda > 0)
    for (std::size_t i = 0; i < spread.variance.size(); ++i)
      result.weight[i] = static_cast<float>(std::sqrt(spread.variance[i]) / (spread.variance[i] + lambda));
  return result;
}

/// An image with equal probabilities for all labels lies on the diagonal, which log-ratios and centered
/// probabilities map to 0: it is orthogonal to everything, and equal to another such image.
void scaleToUnit(std::span<float> vector) {
  const float norm = std::sqrt(dot(vector, vector));
  if (norm > 0)
    for (float& v : vector) v /= norm;
  else
    std::fill(vector.begin(), vector.end(), 1 / std::sqrt(static_cast<float>(vector.size())));
}

/// Divergences grow with the vectors as squared differences grow with their squares.
bool isDivergence(Comparison comparison) {
  return comparison == Comparison::chiSquared || comparison == Comparison::kullbackLeibler ||
         comparison == Comparison::jensenShannon;
}

/// One cosine of vectors whose parts have the lengths √(w / Σ w) is the weighted mean of the parts' own
/// cosines. For other distances a weight acts on squared differences, or on divergences.
void balance(const Distance& distance, std::span<float> vector) {
  const bool cosine = distance.comparison == Comparison::cosine;
  if (distance.parts.size() < 2) {
    if (cosine) scaleToUnit(vector);
    return;
  }
  float sum = 0;
  for (const LabelPart& part : distance.parts) sum += part.weight;
  for (std::size_t first = 0; const LabelPart& part : distance.parts) {
    const std::span<float> own = vector.subspan(first, part.size);
    if (cosine) scaleToUnit(own);
    const float share = part.weight / sum * (cosine ? 1.0F : static_cast<float>(distance.parts.size()));
    const float scale = isDivergence(distance.comparison) ? share : std::sqrt(share);
    if (scale != 1)
      for (float& value : own) value *= scale;
    first += part.size;
  }
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
  // A standing camera's noise is about .015, at most .04, against .15 and more between views of a moving one.
  if (lastView_.empty() || compare(Comparison::cosine, ratios, lastView_) > 0.05) {
    lastView_ = std::move(ratios);
    memory_.lastView = memory_.frames - 1;
    memory_.repeats = 0;
    ++memory_.views;
    return true;
  }
  return ++memory_.repeats < 10;  // more frames of one view do not count
}

bool LabelScale::add(std::span<const float> probabilities, std::span<const float> embedded) {
  ++memory_.frames;
  if (!counts(probabilities, embedded)) return false;
  ++memory_.keyframes;
  moments_.add(embedded);
  return true;
}

bool LabelScale::hasSeenEnough() const {
  return memory_.views >= 3;  // fewer may be noise
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

DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance,
                                 const Standardization& standardization) {
  std::vector<float> embedded(descriptors.labels());
  DescriptorMatrix vectors(descriptors.labels());
  vectors.reserve(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    embed(distance.embedding, descriptors.row(i), embedded, distance.parts);
    vectors.append(comparedVector(distance, standardization, embedded));
  }
  return vectors;
}

std::vector<float> comparedVector(const Distance& distance, const Standardization& standardization,
                                  std::span<const float> embedded) {
  std::vector<float> vector(embedded.begin(), embedded.end());
  if (!standardization.weight.empty())
    for (std::size_t i = 0; i < vector.size(); ++i)
      vector[i] = (vector[i] - standardization.center[i]) * standardization.weight[i];
  balance(distance, vector);
  return vector;
}

DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const DescriptorMatrix& scale,
                                 const Distance& distance) {
  std::vector<float> embedded(descriptors.labels());
  LabelScale run(distance, descriptors.labels());
  if (distance.standardized)
    for (std::size_t i = 0; i < scale.size(); ++i) {
      embed(distance.embedding, scale.row(i), embedded, distance.parts);
      run.add(scale.row(i), embedded);
    }
  return comparedVectors(descriptors, distance, run.standardization());
}

DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance) {
  if (!distance.standardized) return comparedVectors(descriptors, distance, Standardization{});
  std::vector<float> embedded(descriptors.labels());
  Moments moments(descriptors.labels(), true);
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    embed(distance.embedding, descriptors.row(i), embedded, distance.parts);
    moments.add(embedded);
  }
  return comparedVectors(descriptors, distance, standardizationBy(moments));
}

}  // namespace estancia
