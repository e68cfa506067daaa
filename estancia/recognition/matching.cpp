// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/matching.hpp"

#include <algorithm>

#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

float squaredDistance(DescriptorView a, DescriptorView b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace

std::vector<std::vector<NearRow>> nearestRows(const DescriptorMatrix& rows, const DescriptorMatrix& others,
                                              std::size_t count, int threads) {
  std::vector<std::vector<NearRow>> found(rows.size());
  count = std::min(count, others.size());
  if (count == 0) return found;
  // A few more than needed, because rounding of the product may swap near rows; the exact distance decides.
  const std::size_t kept = std::min(count + 3, others.size());
  // |a − b|² = |a|² + |b|² − 2 a·b, and |a|² changes no order.
  const std::vector<float> norms = squaredNorms(others);
  rowProducts(rows, PackedRows(others), threads, [&](std::size_t i, std::span<float> products) {
    std::vector<NearRow>& best = found[i];
    best.reserve(kept + 1);
    for (std::uint32_t j = 0; j < products.size(); ++j) {
      const float squared = norms[j] - 2 * products[j];
      if (best.size() == kept && !(squared < best.back().squared)) continue;
      const auto after = std::upper_bound(best.begin(), best.end(), squared,
                                          [](float s, const NearRow& n) { return s < n.squared; });
      best.insert(after, {j, squared});
      if (best.size() > kept) best.pop_back();
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
