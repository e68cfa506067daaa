// Wilson score interval: confidence interval of a proportion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {

/// Wilson interval for a `share` of an effective number of `trials`, which need not be whole. The interval
/// contains the share. Throws Error (invalidInput) unless the share is in [0, 1] and the trials are above 0.
inline std::pair<double, double> wilsonInterval(double share, double trials) {
  if (!(share >= 0 && share <= 1 && trials > 0))
    fail(ErrorCode::invalidInput, "the share is {} of {} trials; give 0 to 1 of more than 0", share, trials);
  constexpr double z = 1.959963984540054;  // quantile of the normal distribution at 97.5 %
  const double scale = 1 + z * z / trials;
  const double middle = (share + z * z / (2 * trials)) / scale;
  const double half = z / scale * std::sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials));
  return {std::clamp(middle - half, 0.0, share), std::clamp(middle + half, share, 1.0)};
}

/// The 95 % confidence interval of a probability from `hits` in independent `trials` (Wilson 1927, score
/// interval): in [0, 1], also for no hits or hits only. Throws Error (invalidInput) for 0 trials, more hits.
inline std::pair<double, double> wilsonInterval(std::size_t hits, std::size_t trials) {
  if (trials == 0 || hits > trials)
    fail(ErrorCode::invalidInput, "there are {} hits in {} trials; give at least one trial, and no more hits",
         hits, trials);
  const auto n = static_cast<double>(trials);
  return wilsonInterval(static_cast<double>(hits) / n, n);
}

}  // namespace estancia
