// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/surroundings.hpp"

#include <cmath>
#include <vector>

#include "estancia/core/parallel.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/compared_vectors.hpp"

namespace estancia {
namespace {

constexpr double wayOfOnePlace = 0.75;  // in distances of unrelated images: .5 to 1 are as good on all sets
constexpr double farthest = 3;          // standard deviations; weights beyond, below .011, are 0

/// Whether poses distinguish images.
bool isSpread(const std::vector<Frame>& frames, double reach) {
  const Pose* first = nullptr;
  for (const Frame& frame : frames) {
    if (!frame.pose) continue;
    if (first == nullptr) first = &*frame.pose;
    if (distanceBetween(*first, *frame.pose) > reach) return true;
  }
  return false;
}

/// The way through the images up to each of them, 1 for one place.
std::vector<double> waysThrough(const DescriptorSequence& sequence, const ZoneOptions& options) {
  const Distance distance = getDistance(options.distance, sequence.vocabulary.layout().parts);
  const DescriptorMatrix vectors = comparedVectors(sequence.descriptors, distance);
  const std::size_t n = vectors.size();
  double unrelated = 0;  // mean of images half a run apart
  std::vector<double> ways(n);
  for (std::size_t i = 0; i < n; ++i) {
    unrelated +=
        compare(distance.comparison, vectors.row(i), vectors.row((i + n / 2) % n)) / static_cast<double>(n);
    if (i > 0) ways[i] = ways[i - 1] + compare(distance.comparison, vectors.row(i - 1), vectors.row(i));
  }
  if (unrelated > 0)
    for (double& way : ways) way /= wayOfOnePlace * unrelated;
  return ways;
}

}  // namespace

Surroundings poolSurroundings(const DescriptorSequence& sequence, const ZoneOptions& options,
                              Progress& progress) {
  const double reach = options.reach.value_or(0);
  const std::size_t n = sequence.frames.size(), labels = sequence.descriptors.labels();
  const bool inSpace = isSpread(sequence.frames, reach);
  const std::vector<double> ways = waysThrough(sequence, options);
  const auto weight = [&](std::size_t i, std::size_t j) {
    const auto &a = sequence.frames[i].pose, &b = sequence.frames[j].pose;
    const double far = inSpace && a && b ? distanceBetween(*a, *b) / reach : std::abs(ways[i] - ways[j]);
    return far < farthest ? std::exp(-far * far / 2) : 0;
  };
  std::vector<std::vector<float>> pooled(n);
  std::vector<double> total(n);
  inParallel(n, options.threads, progress, "stopped before the surroundings were known", [&](std::size_t i) {
    std::vector<double> sum(labels);
    for (std::size_t j = 0; j < n; ++j) {
      const double w = weight(i, j);
      if (w == 0) continue;
      total[i] += w;
      const DescriptorView other = sequence.descriptors.row(j);
      for (std::size_t l = 0; l < labels; ++l) sum[l] += w * other[l];
    }
    for (const double value : sum) pooled[i].push_back(static_cast<float>(value / total[i]));
  });
  Surroundings result{DescriptorMatrix(labels)};
  result.descriptors.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.descriptors.append(pooled[i]);
    result.others += (total[i] - 1) / static_cast<double>(n);
  }
  return result;
}

}  // namespace estancia
