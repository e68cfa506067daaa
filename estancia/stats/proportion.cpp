#include "estancia/stats/proportion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/core/error.hpp"

namespace estancia {

std::pair<double, double> wilsonInterval(std::size_t hits, std::size_t trials) {
  if (trials == 0 || hits > trials)
    throw Error(fmt::format("{} hits in {} trials are no share; count at least one trial", hits, trials));
  constexpr double z = 1.959963984540054;  // of the normal distribution at 97.5 %
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(hits) / n;
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

}  // namespace estancia
