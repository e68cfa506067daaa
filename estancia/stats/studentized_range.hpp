// Studentized range: its distribution, for Nemenyi's test.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace estancia {

/// P(max − min > q) of `groups` independent standard normal variables: the upper tail of the studentized
/// range with infinite degrees of freedom (R's ptukey(q, groups, Inf, lower.tail = FALSE)). Its error is
/// below 1e-12, absolute and relative to the tail, however far out. Throws Error (invalidInput) for fewer
/// than 2 groups or a NaN.
double studentizedRangeTail(double q, std::size_t groups);

/// The q whose tail is alpha (R's qtukey), to a relative 1e-12; 2.343701 for alpha = 0.05 and 3 groups … once
/// divided by √2. Throws Error for fewer than 2 groups or an alpha that is not inside (0, 1).
double studentizedRangeQuantile(double alpha, std::size_t groups);

}  // namespace estancia
