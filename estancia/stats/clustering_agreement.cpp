// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/clustering_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Counts as doubles: exact up to 2⁵³, and their pairs are what the formulas want.
using Counts = std::map<int, double>;

double entropy(const Counts& counts, double total) {
  double sum = 0;
  for (const auto& [name, count] : counts) sum -= count / total * std::log(count / total);
  return sum;
}

double pairs(double count) {
  return count * (count - 1) / 2;
}

void requireSameLength(std::size_t classes, std::size_t clusters) {
  if (classes != clusters)
    fail(ErrorCode::mismatch, "there are {} true classes and {} cluster numbers; give one of each an item",
         classes, clusters);
}

double share(double part, double whole) {  // rounding may leave the interval by an ulp
  return whole <= 0 ? 1 : std::clamp(part / whole, 0.0, 1.0);
}

}  // namespace

Agreement measureAgreement(std::span<const int> truth, std::span<const int> clusters) {
  requireSameLength(truth.size(), clusters.size());
  if (truth.empty()) throw Error(ErrorCode::invalidInput, "a clustering has no items; give at least one");

  std::map<std::pair<int, int>, double> joint;  // (cluster, class)
  Counts classes, sizes, largest;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++joint[{clusters[i], truth[i]}];
    ++classes[truth[i]];
    ++sizes[clusters[i]];
  }
  const auto total = static_cast<double>(truth.size());

  double information = 0, pairsTogether = 0, correct = 0;
  for (const auto& [key, count] : joint) {
    information += count / total * std::log(total * count / (sizes[key.first] * classes[key.second]));
    pairsTogether += pairs(count);
    largest[key.first] = std::max(largest[key.first], count);
  }
  for (const auto& [cluster, count] : largest) correct += count;

  Agreement result;
  result.homogeneity = share(information, entropy(classes, total));
  result.completeness = share(information, entropy(sizes, total));
  const double sum = result.homogeneity + result.completeness;
  result.vMeasure = sum > 0 ? 2 * result.homogeneity * result.completeness / sum : 0;
  result.purity = correct / total;

  double pairsInClasses = 0, pairsInClusters = 0;
  for (const auto& [name, count] : classes) pairsInClasses += pairs(count);
  for (const auto& [name, count] : sizes) pairsInClusters += pairs(count);
  const double expected = total > 1 ? pairsInClasses * pairsInClusters / pairs(total) : 0;
  const double best = (pairsInClasses + pairsInClusters) / 2;
  // Equal only when both are one cluster, or both are all singletons: the same partition.
  result.adjustedRandIndex = best == expected ? 1 : (pairsTogether - expected) / (best - expected);
  return result;
}

NamedAgreement measureNamedAgreement(std::span<const std::string> truth, std::span<const int> clusters) {
  requireSameLength(truth.size(), clusters.size());
  std::map<std::string, int> numbers;
  std::vector<int> known, theirs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i].empty()) continue;
    known.push_back(numbers.emplace(truth[i], static_cast<int>(numbers.size())).first->second);
    theirs.push_back(clusters[i]);
  }
  if (known.empty()) return {};
  return {known.size(), measureAgreement(known, theirs)};
}

std::vector<std::size_t> keptNumbers(std::size_t groups, const GroupOverlap& overlap) {
  std::vector<std::pair<std::pair<std::size_t, std::size_t>, std::size_t>> pairs(overlap.begin(),
                                                                                 overlap.end());
  std::ranges::stable_sort(pairs, std::greater(), [](const auto& pair) { return pair.second; });
  std::vector<std::size_t> numbers(groups, groups);
  std::vector<bool> isTaken(groups, false);
  for (const auto& [pair, members] : pairs) {
    const auto [group, before] = pair;
    if (group >= groups || before >= groups || numbers[group] < groups || isTaken[before]) continue;
    numbers[group] = before;
    isTaken[before] = true;
  }
  std::size_t free = 0;
  for (std::size_t& number : numbers) {
    if (number < groups) continue;
    while (isTaken[free]) ++free;
    number = free;
    isTaken[free] = true;
  }
  return numbers;
}

}  // namespace estancia
