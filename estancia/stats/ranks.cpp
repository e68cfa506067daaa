#include "estancia/stats/ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/error.hpp"

namespace estancia {

std::vector<double> ranks(std::span<const double> values) {
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    throw Error("values that are not finite have no rank");
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> result(values.size());
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    const double shared = static_cast<double>(first + 1 + end) / 2;  // the mean of first+1 … end
    for (std::size_t i = first; i < end; ++i) result[order[i]] = shared;
  }
  return result;
}

std::vector<Standing> standings(const std::vector<std::vector<double>>& tests) {
  if (tests.empty()) throw Error("without tests nobody can be ranked");
  std::vector<Standing> result(tests.front().size());
  for (const auto& test : tests) {
    if (test.size() != result.size())
      throw Error(fmt::format("a test of {} competitors beside one of {}", test.size(), result.size()));
    const std::vector<double> rank = ranks(test);
    for (std::size_t c = 0; c < test.size(); ++c) {
      result[c].meanRank += rank[c] / static_cast<double>(tests.size());
      for (std::size_t other = 0; other < test.size(); ++other)
        if (other != c)
          ++(test[c] < test[other]   ? result[c].wins
             : test[c] > test[other] ? result[c].losses
                                     : result[c].ties);
    }
  }
  return result;
}

}  // namespace estancia
