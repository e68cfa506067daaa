// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/kept_numbers.hpp"

#include <algorithm>
#include <tuple>

namespace estancia {

std::vector<std::size_t> keptNumbers(std::size_t groups, const GroupOverlap& overlap) {
  std::vector<std::tuple<std::size_t, std::size_t, std::size_t>> pairs;
  for (const auto& [pair, members] : overlap) pairs.emplace_back(members, pair.first, pair.second);
  std::ranges::sort(pairs, [](const auto& a, const auto& b) {
    return std::tuple(std::get<0>(b), std::get<1>(a), std::get<2>(a)) <
           std::tuple(std::get<0>(a), std::get<1>(b), std::get<2>(b));
  });
  std::vector<std::size_t> numbers(groups, groups);
  std::vector<bool> isTaken(groups, false);
  for (const auto& [members, group, before] : pairs) {
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
