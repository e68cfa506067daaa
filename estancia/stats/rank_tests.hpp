// Rank tests over several methods and tests: mean ranks, Friedman, Wilcoxon and post-hoc tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia {

/// Whether smaller values are better (errors, distances) or larger ones (accuracies).
enum class Better { smaller, larger };

/// Ranks from 1 for the best value on; equal values share the mean of their ranks (with Better::smaller,
/// SciPy's rankdata). Throws Error (invalidInput) when a value is not finite.
std::vector<double> ranks(std::span<const double> values, Better better);

/// The mean rank of each method, 1 … their number. `tests[t][m]` is the score of method m in test t. Methods
/// whose ranks add up to the same have exactly the same mean. Throws Error (invalidInput) when there is no
/// test, or their lengths differ, or a value is not finite.
std::vector<double> meanRanks(const std::vector<std::vector<double>>& tests, Better better);

/// How often one method was better than, as good as, and worse than another.
struct WinRecord {
  std::size_t wins = 0, ties = 0, losses = 0;

  bool operator==(const WinRecord&) const = default;
};

/// `one` against `other` in all tests, laid out as for meanRanks().
WinRecord recordAgainst(const std::vector<std::vector<double>>& tests, std::size_t one, std::size_t other,
                        Better better);

/// One method against all others in all tests.
struct MethodStanding : WinRecord {
  /// 1 … number of methods.
  double meanRank = 0;
};

/// Ranks methods by several tests (thesis 4.5.2, Fig. 4.5), one standing a method, as for meanRanks().
std::vector<MethodStanding> standings(const std::vector<std::vector<double>>& tests, Better better);

/// Friedman's test of the hypothesis that all k methods are equivalent in N tests, and the less conservative
/// statistic that Iman and Davenport derived from it.
struct FriedmanTest {
  /// χ²_F, corrected for ties; as SciPy's friedmanchisquare.
  double chiSquared = 0;
  /// k − 1
  std::size_t degrees = 0;
  /// p-value of χ²_F, by the χ² distribution.
  double p = 1;
  /// F_F; infinite when all tests rank the methods alike.
  double f = 0;
  /// k − 1 and (k − 1)(N − 1)
  std::size_t fDegrees = 0, fOtherDegrees = 0;
  /// p-value of F_F, by the F distribution, but at least k!^(1 − N), the probability that N tests rank alike
  /// by chance, the smallest p-value possible: for a few tests that agree the distribution would give 0.
  double fP = 1;
  /// Why there is nothing to test (one method, one test, all values equal), "" otherwise; both p are 1 then.
  std::string undefined;
};

/// `tests[t][m]` is the score of method m in test t; whether smaller or larger is better does not matter.
///
/// With R_j the mean rank of method j, t the sizes of groups of equal values within a test:
///     χ²_F = 12 N / (k (k + 1)) Σ_j (R_j − (k + 1)/2)² / (1 − Σ (t³ − t) / (N (k³ − k)))
///     F_F = (N − 1) χ²_F / (N (k − 1) − χ²_F)
/// Friedman, J. Am. Stat. Assoc. 32 (1937) and Ann. Math. Stat. 11 (1940); Iman & Davenport, Commun. Stat. A9
/// (1980); Demšar, JMLR 7 (2006), 3.2.2 (whose χ²_F leaves ties uncorrected). The distributions are
/// approximations, fair from about N > 10 and k > 5 on (Demšar). Throws Error as meanRanks().
FriedmanTest friedmanTest(const std::vector<std::vector<double>>& tests);

/// Wilcoxon's signed-rank test of the hypothesis that the differences lie symmetrically around 0.
struct WilcoxonTest {
  /// Sum of the ranks of |a − b| where a is larger.
  double better = 0;
  /// Sum of the ranks where b is larger.
  double worse = 0;
  /// Tests where they differ; the others are left out, as Wilcoxon did.
  std::size_t different = 0;
  /// Whether p is that of the exact distribution: up to 50 differences, no two of the same size, none of 0.
  /// Else it is that of the normal distribution, whose variance is corrected for ties.
  bool exact = false;
  /// z of the normal approximation: (better − mean) / √variance; 0 where exact.
  double z = 0;
  /// Two-sided; 1 when they nowhere differ.
  double p = 1;
};

/// `a` and `b` are the scores of the two methods in each test. The p-values are those of SciPy's wilcoxon()
/// (zero_method "wilcox", no correction for continuity) in the mode that `exact` names. Wilcoxon, Biometrics
/// 1 (1945); variance n (n + 1)(2 n + 1) / 24 − Σ (t³ − t) / 48 (Lehmann 1975). Differences are taken as they
/// are: of numbers that were rounded before, equal ones may differ in the last bit and are not tied. Throws
/// Error (mismatch, invalidInput) when lengths differ, there is no test, or a value is not finite.
WilcoxonTest wilcoxonTest(std::span<const double> a, std::span<const double> b);

/// Post-hoc test: the hypotheses that are tested, and how their p-values are adjusted for their number.
enum class PostHoc {
  /// Each method against one control; Holm, Scand. J. Stat. 6 (1979).
  holm,
  /// All pairs; static procedure of Shaffer, J. Am. Stat. Assoc. 81 (1986).
  shaffer,
  /// All pairs; Nemenyi (1963), with one critical difference.
  nemenyi,
};

/// The names of PostHoc.
Choices postHocs();

/// Whether two methods differ.
struct PairTest {
  /// With a control, it is the first; else first < second.
  std::size_t first = 0, second = 0;
  /// (R_second − R_first) / √(k (k + 1) / 6N); above 0: the first is better.
  double z = 0;
  /// Two-sided, by the normal distribution.
  double p = 1;
  /// p adjusted for the number of hypotheses; compare it with α directly.
  double adjusted = 1;
};

/// Tests methods by their mean ranks over `tests` tests (Demšar, JMLR 7 (2006), 3.2.2; García & Herrera, JMLR
/// 9 (2008)). The mean ranks that a paper prints are enough. With Holm, `control` against each other
/// method in their order; else all pairs in the order (0, 1), (0, 2) …, and `control` is ignored. One method
/// has no pairs. Throws Error (invalidInput, tooLarge) when there is no test, a mean rank is outside
/// [1, k], the control does not exist, or there are more than 500 methods in all pairs.
std::vector<PairTest> postHocTests(PostHoc postHoc, std::span<const double> meanRanks, std::size_t tests,
                                   std::size_t control = 0);

/// Holm's adjustment of p-values, in their order: with them ascending, max over j ≤ i of (m + 1 − j) p_j, at
/// most 1. Throws Error (invalidInput) when one is outside [0, 1].
std::vector<double> holmAdjusted(std::span<const double> p);

/// Shaffer's static adjustment of the p-values of all pairs of `methods` methods: as Holm's, but with the
/// number of hypotheses that can still be true together in place of m + 1 − j. (If A and B differ, not both
/// can equal C.) Throws Error (invalidInput) unless there is one a pair, and as holmAdjusted().
std::vector<double> shafferAdjusted(std::span<const double> p, std::size_t methods);

/// P(max − min > q) of `groups` independent standard normal variables: the upper tail of the studentized
/// range with infinite degrees of freedom (R's ptukey(q, groups, Inf, lower.tail = FALSE)). Its error is
/// below 1e-12, absolute and relative to the tail. Throws Error (invalidInput) below 2 groups and for NaN.
double studentizedRangeTail(double q, std::size_t groups);

/// The q whose tail is alpha (R's qtukey), to a relative 1e-12; 2.343701 for alpha = 0.05 and 3 groups … once
/// divided by √2. Throws Error for fewer than 2 groups or an alpha that is not inside (0, 1).
double studentizedRangeQuantile(double alpha, std::size_t groups);

/// The critical difference of two mean ranks by Nemenyi's test: q_α √(k (k + 1) / 6N), q_α the quantile of
/// the studentized range over √2. Throws Error (invalidInput) without tests; as studentizedRangeQuantile().
double criticalDifference(double alpha, std::size_t methods, std::size_t tests);

}  // namespace estancia
