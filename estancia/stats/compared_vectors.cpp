// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/compared_vectors.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

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
