// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"

#include <algorithm>
#include <boost/dynamic_bitset.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Σ (t³ − t) over the groups of t equal values.
double tieTerm(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double sum = 0;
  for (std::size_t first = 0, end = 0; first < values.size(); first = end) {
    while (end < values.size() && values[end] == values[first]) ++end;
    const auto t = static_cast<double>(end - first);
    sum += t * t * t - t;
  }
  return sum;
}

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

constexpr std::size_t maxInPairs = 500;  // methods; their pairs are 124,750

/// The standard error of the difference of two mean ranks.
double standardError(std::size_t methods, std::size_t tests) {
  const auto k = static_cast<double>(methods);
  return std::sqrt(k * (k + 1) / (6 * static_cast<double>(tests)));
}

/// Step-down adjustment: hypotheses(i) are those that count when the i smallest p-values (i = 0 …) are gone.
std::vector<double> stepDown(std::span<const double> p,
                             const std::function<std::size_t(std::size_t)>& hypotheses) {
  for (const double value : p)
    if (!(value >= 0 && value <= 1)) fail(ErrorCode::invalidInput, "a p-value is {}; give 0 to 1", value);
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

/// Φ(z), also far below 0.
double normalBelow(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

}  // namespace

std::vector<double> ranks(std::span<const double> values, Better better) {
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    throw Error(ErrorCode::invalidInput, "a score is not finite; leave its test out");
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
  if (tests.empty()) throw Error(ErrorCode::invalidInput, "there are no tests; give at least one");
  std::vector<double> means(tests.front().size());
  for (const auto& test : tests) {
    if (test.size() != means.size())
      fail(ErrorCode::mismatch, "one test has {} methods, another {}; give each test all methods",
           test.size(), means.size());
    const std::vector<double> rank = ranks(test, better);
    for (std::size_t c = 0; c < rank.size(); ++c) means[c] += rank[c];  // halves: exact
  }
  for (double& mean : means) mean /= static_cast<double>(tests.size());
  return means;
}

WinRecord recordAgainst(const std::vector<std::vector<double>>& tests, std::size_t one, std::size_t other,
                        Better better) {
  WinRecord record;
  for (const auto& test : tests) {
    const double ahead =
        better == Better::smaller ? test.at(other) - test.at(one) : test.at(one) - test.at(other);
    ++(ahead > 0 ? record.wins : ahead < 0 ? record.losses : record.ties);
  }
  return record;
}

std::vector<MethodStanding> standings(const std::vector<std::vector<double>>& tests, Better better) {
  const std::vector<double> means = meanRanks(tests, better);
  std::vector<MethodStanding> result(means.size());
  for (std::size_t c = 0; c < result.size(); ++c) {
    result[c].meanRank = means[c];
    for (std::size_t other = 0; other < result.size(); ++other) {
      if (other == c) continue;
      const WinRecord record = recordAgainst(tests, c, other, better);
      result[c].wins += record.wins;
      result[c].ties += record.ties;
      result[c].losses += record.losses;
    }
  }
  return result;
}

FriedmanTest friedmanTest(const std::vector<std::vector<double>>& tests) {
  const std::vector<double> rank = meanRanks(tests, Better::smaller);
  FriedmanTest result;
  if (rank.size() < 2) {
    result.undefined = "there is one method only";
    return result;
  }
  const auto k = static_cast<double>(rank.size()), n = static_cast<double>(tests.size());
  result.degrees = result.fDegrees = rank.size() - 1;
  result.fOtherDegrees = result.degrees * (tests.size() - 1);
  double ties = 0, spread = 0;
  for (const auto& test : tests) ties += tieTerm(test);
  const double untied = 1 - ties / (n * (k * k * k - k));
  if (tests.size() < 2)
    result.undefined = "there is one test only";
  else if (untied <= 0)
    result.undefined = "all methods have equal scores in every test";
  if (!result.undefined.empty()) return result;

  for (const double r : rank) spread += (r - (k + 1) / 2) * (r - (k + 1) / 2);
  const double maximum = n * (k - 1);  // maximum of χ²_F: all tests rank alike
  result.chiSquared = std::min(12 * n / (k * (k + 1)) * spread / untied, maximum);
  using namespace boost::math;
  result.p = cdf(complement(chi_squared(k - 1), result.chiSquared));
  double chance = 0;
  if (maximum - result.chiSquared > 1e-12 * maximum) {
    result.f = (n - 1) * result.chiSquared / (maximum - result.chiSquared);
    chance = cdf(complement(fisher_f(k - 1, (k - 1) * (n - 1)), result.f));
  } else {
    result.f = std::numeric_limits<double>::infinity();
  }
  result.fP = std::max(chance, std::exp((1 - n) * std::lgamma(k + 1)));
  return result;
}

WilcoxonTest wilcoxonTest(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size())
    fail(ErrorCode::mismatch, "one method has {} tests, the other {}; give both the same", a.size(),
         b.size());
  if (a.empty()) throw Error(ErrorCode::invalidInput, "there are no tests; give at least one");
  std::vector<double> sizes;
  std::vector<bool> aIsLarger;
  for (std::size_t t = 0; t < a.size(); ++t) {
    if (!std::isfinite(a[t]) || !std::isfinite(b[t]))
      fail(ErrorCode::invalidInput, "the scores in test {} are {} and {}; give finite numbers", t + 1, a[t],
           b[t]);
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
  result.exact = sizes.size() == a.size() && values.size() == sizes.size() && sizes.size() <= 50;
  if (result.exact) {
    result.p = exactP(sizes.size(), static_cast<std::size_t>(std::min(result.better, result.worse)));
    return result;
  }
  const double variance = n * (n + 1) * (2 * n + 1) / 24 - tieTerm(sizes) / 48;
  result.z = (result.better - n * (n + 1) / 4) / std::sqrt(variance);
  result.p = std::erfc(std::abs(result.z) / std::numbers::sqrt2);
  return result;
}

Choices postHocs() {
  return {{"holm", "each method against one control"},
          {"shaffer", "all pairs of methods"},
          {"nemenyi", "all pairs, by one critical difference, as a rule less powerful"}};
}

std::vector<PairTest> postHocTests(PostHoc postHoc, std::span<const double> meanRanks, std::size_t tests,
                                   std::size_t control) {
  const std::size_t k = meanRanks.size();
  if (tests == 0) throw Error(ErrorCode::invalidInput, "there are no tests; give at least one");
  for (const double rank : meanRanks)
    if (!(rank >= 1 && rank <= static_cast<double>(k)))
      fail(ErrorCode::invalidInput, "a mean rank of {} methods is {}; give 1 to {}", k, rank, k);
  const bool withControl = postHoc == PostHoc::holm;
  if (withControl && control >= k)
    fail(ErrorCode::invalidInput, "the control is method {} of {}; give a smaller number", control, k);
  if (!withControl && k > maxInPairs)
    fail(ErrorCode::tooLarge,
         "{} methods have too many pairs (the limit is {} methods); compare them with a control", k,
         maxInPairs);

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
  for (const PairTest& pair : pairs) p.push_back(pair.p);
  const std::vector<double> adjusted = withControl ? holmAdjusted(p) : shafferAdjusted(p, k);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].adjusted = adjusted[i];
  return pairs;
}

std::vector<double> holmAdjusted(std::span<const double> p) {
  return stepDown(p, [&](std::size_t i) { return p.size() - i; });
}

std::vector<double> shafferAdjusted(std::span<const double> p, std::size_t methods) {
  if (methods > maxInPairs || p.size() != methods * (methods - (methods > 0 ? 1 : 0)) / 2)
    fail(ErrorCode::invalidInput, "there are {} p-values for all pairs of {} methods; give one a pair",
         p.size(), methods);
  if (p.empty()) return {};
  const boost::dynamic_bitset<> possible = possiblyTrue(methods);
  std::size_t hypotheses = p.size();  // p ascends, so this only falls
  return stepDown(p, [&](std::size_t i) {
    while (hypotheses > p.size() - i || !possible.test(hypotheses)) --hypotheses;
    return hypotheses;
  });
}

double studentizedRangeTail(double q, std::size_t groups) {
  if (groups < 2) fail(ErrorCode::invalidInput, "there are {} groups; give at least 2", groups);
  if (std::isnan(q)) throw Error(ErrorCode::invalidInput, "the range is NaN; give a number");
  if (q <= 0) return 1;
  // P(range ≤ q) = k ∫ φ(z) [Φ(z) − Φ(z − q)]^(k−1) dz, where z is the largest variable, and with q = ∞ it is
  // 1. The difference of both, with a = Φ(z) and d = Φ(z − q), has no cancellation as a^(k−1) (1 − (1 −
  // d/a)^(k−1)). The trapezoidal rule converges geometrically for such an integrand (Trefethen & Weideman
  // 2014); at this step its error is below the rounding.
  constexpr double step = 1.0 / 32, reach = 12;  // φ vanishes beyond ±12 of where the integrand peaks
  const double others = static_cast<double>(groups) - 1;
  const auto first = static_cast<long>(-reach / step);
  const auto last = static_cast<long>(std::min(q / 2 + reach, 40.0) / step);
  double sum = 0;
  for (long i = first; i <= last; ++i) {
    const double z = static_cast<double>(i) * step, all = normalBelow(z);
    const double outside = std::min(normalBelow(z - q) / all, 1.0);
    sum += std::exp(-z * z / 2 + others * std::log(all)) * -std::expm1(others * std::log1p(-outside));
  }
  const double tail = (others + 1) * step * sum / std::sqrt(2 * std::numbers::pi);
  return std::clamp(tail, 0.0, 1.0);
}

double studentizedRangeQuantile(double alpha, std::size_t groups) {
  if (!(alpha > 0 && alpha < 1))
    fail(ErrorCode::invalidInput, "alpha is {}; give a number between 0 and 1", alpha);
  double upper = 1;
  while (studentizedRangeTail(upper, groups) > alpha) upper *= 2;
  std::uintmax_t steps = 200;
  const auto [low, high] = boost::math::tools::toms748_solve(
      [&](double q) { return std::log(studentizedRangeTail(q, groups) / alpha); }, 0.0, upper,
      boost::math::tools::eps_tolerance<double>(44), steps);
  return (low + high) / 2;
}

double criticalDifference(double alpha, std::size_t methods, std::size_t tests) {
  if (tests == 0) throw Error(ErrorCode::invalidInput, "there are no tests; give at least one");
  return studentizedRangeQuantile(alpha, methods) / std::numbers::sqrt2 * standardError(methods, tests);
}

}  // namespace estancia
