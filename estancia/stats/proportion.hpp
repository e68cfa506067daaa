// Wilson score interval: confidence interval of a proportion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>

namespace estancia {

/// The 95 % confidence interval of a probability from `hits` in `trials` (Wilson 1927, score interval): in
/// [0, 1], also for no hits or hits only. Trials are assumed independent. Throws Error (invalidInput) without
/// trials, or with more hits than trials.
std::pair<double, double> wilsonInterval(std::size_t hits, std::size_t trials);

/// Wilson interval for a `share` of an effective number of `trials`, which need not be whole. The interval
/// contains the share. Throws Error (invalidInput) unless the share is in [0, 1] and the trials are above 0.
std::pair<double, double> wilsonInterval(double share, double trials);

}  // namespace estancia
