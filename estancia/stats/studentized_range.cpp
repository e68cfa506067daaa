// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/studentized_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

/// Φ(z), also far below 0.
double normalBelow(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

}  // namespace

double studentizedRangeTail(double q, std::size_t groups) {
  if (groups < 2)
    throw Error(ErrorCode::invalidInput, fmt::format("there are {} groups; give at least 2", groups));
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
    throw Error(ErrorCode::invalidInput, fmt::format("alpha is {}; give a number between 0 and 1", alpha));
  double upper = 1;
  while (studentizedRangeTail(upper, groups) > alpha) upper *= 2;
  std::uintmax_t steps = 200;
  const auto [low, high] = boost::math::tools::toms748_solve(
      [&](double q) { return std::log(studentizedRangeTail(q, groups) / alpha); }, 0.0, upper,
      boost::math::tools::eps_tolerance<double>(44), steps);
  return (low + high) / 2;
}

}  // namespace estancia
