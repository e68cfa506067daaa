#include "estancia/stats/friedman.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "estancia/stats/mean_ranks.hpp"

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

}  // namespace

FriedmanTest friedmanTest(const std::vector<std::vector<double>>& tests) {
  const std::vector<double> rank = meanRanks(tests, Better::smaller);
  FriedmanTest result;
  if (rank.size() < 2) {
    result.undefined = "one method alone cannot differ";
    return result;
  }
  const auto k = static_cast<double>(rank.size()), n = static_cast<double>(tests.size());
  result.degrees = result.fDegrees = rank.size() - 1;
  result.fOtherDegrees = result.degrees * (tests.size() - 1);
  double ties = 0, spread = 0;
  for (const auto& test : tests) ties += tieTerm(test);
  const double untied = 1 - ties / (n * (k * k * k - k));
  if (tests.size() < 2)
    result.undefined = "one test alone cannot tell luck from merit";
  else if (untied <= 0)
    result.undefined = "all methods reach the same in every test";
  if (!result.undefined.empty()) return result;

  for (const double r : rank) spread += (r - (k + 1) / 2) * (r - (k + 1) / 2);
  const double most = n * (k - 1);  // what χ²_F is when all tests rank alike
  result.chiSquared = std::min(12 * n / (k * (k + 1)) * spread / untied, most);
  using namespace boost::math;
  result.p = cdf(complement(chi_squared(k - 1), result.chiSquared));
  double chance = 0;
  if (most - result.chiSquared > 1e-12 * most) {
    result.f = (n - 1) * result.chiSquared / (most - result.chiSquared);
    chance = cdf(complement(fisher_f(k - 1, (k - 1) * (n - 1)), result.f));
  } else {
    result.f = std::numeric_limits<double>::infinity();
  }
  result.fP = std::max(chance, std::exp((1 - n) * std::lgamma(k + 1)));
  return result;
}

}  // namespace estancia
