// Who is best over many tests.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace estancia {

/// Ranks from 1 for the smallest value on; equal values share the mean of their ranks (SciPy's rankdata).
/// Throws Error when a value is not finite.
std::vector<double> ranks(std::span<const double> values);

/// How one competitor did in all tests.
struct Standing {
  double meanRank = 0;                         ///< 1 … number of competitors
  std::size_t wins = 0, ties = 0, losses = 0;  ///< against each other competitor in each test
};

/// Ranks competitors by several tests (thesis 4.5.2, Fig. 4.5). `tests[t][c]` is what competitor c reached
/// in test t; smaller is better. Returns one standing a competitor. Throws Error when there is no test, or
/// their lengths differ, or a value is not finite.
std::vector<Standing> standings(const std::vector<std::vector<double>>& tests);

}  // namespace estancia
