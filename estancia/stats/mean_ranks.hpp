// Who is best over many tests.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace estancia {

/// Which of two values is the better one: errors and distances are better when smaller, accuracies when
/// larger.
enum class Better { smaller, larger };

/// Ranks from 1 for the best value on; equal values share the mean of their ranks (with Better::smaller,
/// SciPy's rankdata). Throws Error when a value is not finite.
std::vector<double> ranks(std::span<const double> values, Better better);

/// The mean of the ranks of each competitor, 1 … their number. `tests[t][c]` is what competitor c reached in
/// test t. Competitors whose ranks add up to the same have exactly the same mean. Throws Error when there is
/// no test, or their lengths differ, or a value is not finite.
std::vector<double> meanRanks(const std::vector<std::vector<double>>& tests, Better better);

/// How often one competitor did better, as well, and worse.
struct Record {
  std::size_t wins = 0, ties = 0, losses = 0;

  bool operator==(const Record&) const = default;
};

/// How `one` did against `other` in all tests, laid out as for meanRanks().
Record recordAgainst(const std::vector<std::vector<double>>& tests, std::size_t one, std::size_t other,
                     Better better);

/// How one competitor did in all tests, against each other competitor in each test.
struct Standing : Record {
  double meanRank = 0;  ///< 1 … number of competitors
};

/// Ranks competitors by several tests (thesis 4.5.2, Fig. 4.5), laid out as for meanRanks(), which says what
/// is refused. Returns one standing a competitor.
std::vector<Standing> standings(const std::vector<std::vector<double>>& tests, Better better);

}  // namespace estancia
