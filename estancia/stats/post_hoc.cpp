#include "estancia/stats/post_hoc.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/dynamic_bitset.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/stats/studentized_range.hpp"

namespace estancia {
namespace {

constexpr std::size_t mostInPairs = 500;  // methods; their pairs are 124,750

/// The standard error of the difference of two mean ranks.
double standardError(std::size_t methods, std::size_t tests) {
  const auto k = static_cast<double>(methods);
  return std::sqrt(k * (k + 1) / (6 * static_cast<double>(tests)));
}

/// Step-down adjustment: hypotheses(i) are those that count when the i smallest p-values (i = 0 …) are gone.
std::vector<double> stepDown(std::span<const double> p,
                             const std::function<std::size_t(std::size_t)>& hypotheses) {
  for (const double value : p)
    if (!(value >= 0 && value <= 1)) throw Error(fmt::format("{} is no p-value", value));
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double largest = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, static_cast<double>(hypotheses(i)) * p[order[i]]);
    adjusted[order[i]] = std::min(largest, 1.0);
  }
  return adjusted;
}

/// Bit s is set when exactly s of the hypotheses on pairs of k methods can be true: the methods fall into
/// groups of equals, and S(k) = ∪_j { C(j, 2) + s : s ∈ S(k − j) } (Shaffer 1986; García & Herrera 2008).
boost::dynamic_bitset<> possiblyTrue(std::size_t k) {
  const std::size_t pairs = k * (k - 1) / 2;
  std::vector<boost::dynamic_bitset<>> sets(k + 1, boost::dynamic_bitset<>(pairs + 1));
  sets[0].set(0);
  for (std::size_t n = 1; n <= k; ++n)
    for (std::size_t j = 1; j <= n; ++j) sets[n] |= sets[n - j] << (j * (j - 1) / 2);
  return sets[k];
}

}  // namespace

const std::vector<NamedPostHoc>& postHocs() {
  static const std::vector<NamedPostHoc> all = {
      {"holm", PostHoc::holm, "each method against one control"},
      {"shaffer", PostHoc::shaffer, "all pairs of methods"},
      {"nemenyi", PostHoc::nemenyi, "all pairs, by one critical difference, as a rule less powerful"},
  };
  return all;
}

PostHoc getPostHoc(std::string_view name) {
  std::vector<std::string> known;
  for (const NamedPostHoc& one : postHocs()) {
    if (one.name == name) return one.postHoc;
    known.push_back(one.name);
  }
  throw Error(fmt::format("no post-hoc test is called \"{}\"; there are {}", name, fmt::join(known, ", ")));
}

std::vector<PairTest> postHocTests(PostHoc postHoc, std::span<const double> meanRanks, std::size_t tests,
                                   std::size_t control) {
  const std::size_t k = meanRanks.size();
  if (tests == 0) throw Error("without tests there are no ranks to compare");
  for (const double rank : meanRanks)
    if (!(rank >= 1 && rank <= static_cast<double>(k)))
      throw Error(fmt::format("{} is no mean rank of {} methods", rank, k));
  const bool withControl = postHoc == PostHoc::holm;
  if (withControl && control >= k) throw Error(fmt::format("{} methods have no number {}", k, control));
  if (!withControl && k > mostInPairs)
    throw Error(fmt::format(
        "{} methods have too many pairs (at most {} methods); compare them with a control", k, mostInPairs));

  std::vector<PairTest> pairs;
  const auto add = [&](std::size_t a, std::size_t b) {
    const double z = (meanRanks[b] - meanRanks[a]) / standardError(k, tests);
    pairs.push_back({a, b, z, std::erfc(std::abs(z) / std::numbers::sqrt2), 1});
  };
  for (std::size_t a = 0; a < k; ++a)
    if (withControl && a != control)
      add(control, a);
    else if (!withControl)
      for (std::size_t b = a + 1; b < k; ++b) add(a, b);
  if (postHoc == PostHoc::nemenyi) {
    for (PairTest& pair : pairs)
      pair.adjusted = studentizedRangeTail(std::abs(pair.z) * std::numbers::sqrt2, k);
    return pairs;
  }
  std::vector<double> p;
  p.reserve(pairs.size());
  for (const PairTest& pair : pairs) p.push_back(pair.p);
  const std::vector<double> adjusted = withControl ? holmAdjusted(p) : shafferAdjusted(p, k);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].adjusted = adjusted[i];
  return pairs;
}

std::vector<double> holmAdjusted(std::span<const double> p) {
  return stepDown(p, [&](std::size_t i) { return p.size() - i; });
}

std::vector<double> shafferAdjusted(std::span<const double> p, std::size_t methods) {
  if (methods > mostInPairs || p.size() != methods * (methods - (methods > 0 ? 1 : 0)) / 2)
    throw Error(fmt::format("{} p-values are not those of all pairs of {} methods", p.size(), methods));
  if (p.empty()) return {};
  const boost::dynamic_bitset<> possible = possiblyTrue(methods);
  std::size_t most = p.size();  // p ascends, so this only falls
  return stepDown(p, [&](std::size_t i) {
    while (most > p.size() - i || !possible.test(most)) --most;
    return most;
  });
}

double criticalDifference(double alpha, std::size_t methods, std::size_t tests) {
  if (tests == 0) throw Error("without tests there are no ranks to compare");
  return studentizedRangeQuantile(alpha, methods) / std::numbers::sqrt2 * standardError(methods, tests);
}

}  // namespace estancia
