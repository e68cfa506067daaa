#include "estancia/stats/mean_ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/error.hpp"

namespace estancia {

std::vector<double> ranks(std::span<const double> values, Better better) {
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    throw Error("values that are not finite have no rank");
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return better == Better::smaller ? values[a] < values[b] : values[a] > values[b];
  });
  std::vector<double> result(values.size());
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && values[order[end]] == values[order[first]]) ++end;
    const double shared = static_cast<double>(first + 1 + end) / 2;  // the mean of first+1 … end
    for (std::size_t i = first; i < end; ++i) result[order[i]] = shared;
  }
  return result;
}

std::vector<double> meanRanks(const std::vector<std::vector<double>>& tests, Better better) {
  if (tests.empty()) throw Error("without tests nobody can be ranked");
  std::vector<double> means(tests.front().size());
  for (const auto& test : tests) {
    if (test.size() != means.size())
      throw Error(fmt::format("a test of {} competitors beside one of {}", test.size(), means.size()));
    const std::vector<double> rank = ranks(test, better);
    for (std::size_t c = 0; c < rank.size(); ++c) means[c] += rank[c];  // halves: exact
  }
  for (double& mean : means) mean /= static_cast<double>(tests.size());
  return means;
}

Record recordAgainst(const std::vector<std::vector<double>>& tests, std::size_t one, std::size_t other,
                     Better better) {
  Record record;
  for (const auto& test : tests) {
    const double ahead =
        better == Better::smaller ? test.at(other) - test.at(one) : test.at(one) - test.at(other);
    ++(ahead > 0 ? record.wins : ahead < 0 ? record.losses : record.ties);
  }
  return record;
}

std::vector<Standing> standings(const std::vector<std::vector<double>>& tests, Better better) {
  const std::vector<double> means = meanRanks(tests, better);
  std::vector<Standing> result(means.size());
  for (std::size_t c = 0; c < result.size(); ++c) {
    result[c].meanRank = means[c];
    for (std::size_t other = 0; other < result.size(); ++other) {
      if (other == c) continue;
      const Record record = recordAgainst(tests, c, other, better);
      result[c].wins += record.wins;
      result[c].ties += record.ties;
      result[c].losses += record.losses;
    }
  }
  return result;
}

}  // namespace estancia
