// Which methods differ, once Friedman's test says that some do.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// How many hypotheses are tested at once, and how their p-values are adjusted for it.
enum class PostHoc {
  holm,     ///< each method against one control; Holm, Scand. J. Stat. 6 (1979)
  shaffer,  ///< all pairs; static procedure of Shaffer, J. Am. Stat. Assoc. 81 (1986)
  nemenyi,  ///< all pairs; Nemenyi (1963), with a critical difference for all
};

struct NamedPostHoc {
  std::string name;
  PostHoc postHoc;
  std::string explanation;
};

const std::vector<NamedPostHoc>& postHocs();

/// Throws Error listing the known names.
PostHoc getPostHoc(std::string_view name);

/// Whether two methods differ.
struct PairTest {
  std::size_t first = 0, second = 0;  ///< with a control, it is the first; else first < second
  double z = 0;         ///< (R_second − R_first) / √(k (k + 1) / 6N); above 0: the first is better
  double p = 1;         ///< two-sided, by the normal distribution
  double adjusted = 1;  ///< for the number of hypotheses: to be compared with α as it is
};

/// Tests methods by their mean ranks over `tests` tests (Demšar, JMLR 7 (2006), 3.2.2; García & Herrera, JMLR
/// 9 (2008)). Needs no more than the ranks that a paper prints. With Holm, `control` against each other
/// method in their order; else all pairs in the order (0, 1), (0, 2) …, and `control` is ignored. One method
/// has no pairs. Throws Error when there is no test, a mean rank is outside [1, k], the control does not
/// exist, or there are more than 500 methods in all pairs.
std::vector<PairTest> postHocTests(PostHoc postHoc, std::span<const double> meanRanks, std::size_t tests,
                                   std::size_t control = 0);

/// Holm's adjustment of p-values, in their order: with them ascending, max over j ≤ i of (m + 1 − j) p_j, at
/// most 1. Throws Error when one is outside [0, 1].
std::vector<double> holmAdjusted(std::span<const double> p);

/// Shaffer's static adjustment of the p-values of all pairs of `methods` methods: as Holm's, but with the
/// number of hypotheses that can still be true together in place of m + 1 − j. (If A and B differ, not both
/// can equal C.) Throws Error when their number is not that of the pairs, or one is outside [0, 1].
std::vector<double> shafferAdjusted(std::span<const double> p, std::size_t methods);

/// By how much two mean ranks must differ for Nemenyi's test: q_α √(k (k + 1) / 6N), where q_α is the
/// quantile of the studentized range over √2. Throws Error as studentizedRangeQuantile() does, or without a
/// test.
double criticalDifference(double alpha, std::size_t methods, std::size_t tests);

}  // namespace estancia
