#include "estancia/stats/wilcoxon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/stats/mean_ranks.hpp"

namespace estancia {
namespace {

constexpr std::size_t mostExact = 50;

/// P(W ≤ w) · 2, at most 1, where W is the sum of a random subset of the ranks 1 … n and w at most its mean.
double exactP(std::size_t n, std::size_t w) {
  std::vector<double> subsets(w + 1);  // [s]: the share of subsets of the ranks so far whose sum is s
  subsets[0] = 1;
  for (std::size_t rank = 1; rank <= n; ++rank)
    for (std::size_t s = w + 1; s-- > 0;) subsets[s] = (subsets[s] + (s >= rank ? subsets[s - rank] : 0)) / 2;
  double below = 0;
  for (const double share : subsets) below += share;
  return std::min(2 * below, 1.0);
}

}  // namespace

WilcoxonTest wilcoxonTest(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size())
    throw Error(fmt::format("one method with {} tests beside one with {}", a.size(), b.size()));
  if (a.empty()) throw Error("without tests nothing can be compared");
  std::vector<double> sizes;
  std::vector<bool> aIsLarger;
  for (std::size_t t = 0; t < a.size(); ++t) {
    if (!std::isfinite(a[t]) || !std::isfinite(b[t]))
      throw Error(fmt::format("{} and {} in test {} cannot be compared", a[t], b[t], t + 1));
    if (a[t] == b[t]) continue;
    sizes.push_back(std::abs(a[t] - b[t]));
    aIsLarger.push_back(a[t] > b[t]);
  }
  WilcoxonTest result;
  result.different = sizes.size();
  if (sizes.empty()) return result;
  const std::vector<double> rank = ranks(sizes, Better::smaller);
  for (std::size_t i = 0; i < rank.size(); ++i) (aIsLarger[i] ? result.better : result.worse) += rank[i];

  const auto n = static_cast<double>(sizes.size());
  const std::set<double> values(sizes.begin(), sizes.end());
  result.exact = sizes.size() == a.size() && values.size() == sizes.size() && sizes.size() <= mostExact;
  if (result.exact) {
    result.p = exactP(sizes.size(), static_cast<std::size_t>(std::min(result.better, result.worse)));
    return result;
  }
  double ties = 0;
  std::sort(sizes.begin(), sizes.end());
  for (const double value : values) {
    const auto [first, end] = std::equal_range(sizes.begin(), sizes.end(), value);
    const auto t = static_cast<double>(end - first);
    ties += t * t * t - t;
  }
  const double variance = n * (n + 1) * (2 * n + 1) / 24 - ties / 48;
  result.z = (result.better - n * (n + 1) / 4) / std::sqrt(variance);
  result.p = std::erfc(std::abs(result.z) / std::numbers::sqrt2);
  return result;
}

}  // namespace estancia
