// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/matching.hpp"

#include <algorithm>

#include "estancia/core/simd.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

float squaredDistance(DescriptorView a, DescriptorView b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// |b|² − 2 a·b of all b, which orders them by their distance to a, from the products a·b.
ESTANCIA_MULTIVERSION void toSquared(const float* __restrict norms, float* __restrict products,
                                     std::size_t count) {
#pragma omp simd
  for (std::size_t j = 0; j < count; ++j) products[j] = norms[j] - 2 * products[j];
}

ESTANCIA_MULTIVERSION bool anyBelow(const float* values, std::size_t count, float limit) {
  int below = 0;
#pragma omp simd reduction(| : below)
  for (std::size_t j = 0; j < count; ++j) below |= values[j] < limit ? 1 : 0;
  return below != 0;
}

}  // namespace

std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads) {
  std::vector<std::vector<NearRow>> found(rows.size());
  count = std::min(count, others.size());
  if (count == 0) return found;
  // A few more than needed, because rounding of the product may swap near rows; the exact distance decides.
  const std::size_t kept = std::min(count + 3, others.size());
  const std::vector<float> norms = squaredNorms(others);
  rowProducts(rows, PackedRows(others), threads, [&](std::size_t i, std::span<float> products) {
    std::vector<NearRow>& best = found[i];
    best.reserve(kept + 1);
    toSquared(norms.data(), products.data(), products.size());
    constexpr std::size_t together = 64;  // are mostly all farther
    for (std::size_t first = 0; first < products.size(); first += together) {
      const std::size_t last = std::min(first + together, products.size());
      if (best.size() == kept && !anyBelow(&products[first], last - first, best.back().squared)) continue;
      for (std::size_t j = first; j < last; ++j) {
        const float squared = products[j];
        if (best.size() == kept && !(squared < best.back().squared)) continue;
        const auto after = std::upper_bound(best.begin(), best.end(), squared,
                                            [](float s, const NearRow& n) { return s < n.squared; });
        best.insert(after, {static_cast<std::uint32_t>(j), squared});
        if (best.size() > kept) best.pop_back();
      }
    }
    for (NearRow& n : best) n.squared = squaredDistance(rows.row(i), others.row(n.other));
    std::sort(best.begin(), best.end(), [](const NearRow& a, const NearRow& b) {
      return a.squared < b.squared || (a.squared == b.squared && a.other < b.other);
    });
    best.resize(count);
  });
  return found;
}

std::vector<Match> matchDescriptors(const DescriptorMatrix& model, const DescriptorMatrix& scene,
                                    MatchEach each, std::size_t count, double distance, int threads) {
  const bool fromScene = each == MatchEach::scene;
  const auto found =
      fromScene ? nearestRows(scene, model, count, threads) : nearestRows(model, scene, count, threads);
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < found.size(); ++i)
    for (const NearRow& n : found[i])
      matches.push_back(fromScene ? Match{n.other, i, n.squared} : Match{i, n.other, n.squared});
  if (distance > 0) {
    const std::vector<float> norms = squaredNorms(scene);
    const auto share = static_cast<float>(distance * distance);
    std::erase_if(matches, [&](const Match& m) { return m.squared > share * norms[m.scene]; });
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.squared < b.squared; });
  return matches;
}

}  // namespace estancia
