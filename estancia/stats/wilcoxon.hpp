// Do two methods differ, over several tests?
#pragma once

#include <cstddef>
#include <span>

namespace estancia {

/// Wilcoxon's signed-rank test of the hypothesis that the differences lie symmetrically around 0.
struct WilcoxonTest {
  double better = 0;          ///< sum of the ranks of |a − b| where a is larger
  double worse = 0;           ///< and where b is larger
  std::size_t different = 0;  ///< tests where they differ; the others are left out, as Wilcoxon did
  /// Whether p is that of the exact distribution: up to 50 differences, no two of the same size, none of 0.
  /// Else it is that of the normal distribution, whose variance is corrected for ties.
  bool exact = false;
  double z = 0;  ///< of the normal approximation: (better − mean) / √variance; 0 where exact
  double p = 1;  ///< two-sided; 1 when they nowhere differ
};

/// `a` and `b` are what the two reached in each test. The p-values are those of SciPy's wilcoxon()
/// (zero_method "wilcox", no correction for continuity) in the mode that `exact` names. Wilcoxon, Biometrics
/// 1 (1945); variance n (n + 1)(2 n + 1) / 24 − Σ (t³ − t) / 48 (Lehmann 1975). Differences are taken as they
/// are: of numbers that were rounded before, equal differences may differ in the last bit and then are no
/// tie. Throws Error when lengths differ, there is no test, or a value is not finite, saying which.
WilcoxonTest wilcoxonTest(std::span<const double> a, std::span<const double> b);

}  // namespace estancia
