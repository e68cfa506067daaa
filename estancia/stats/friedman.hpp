// Do several methods differ at all, over several tests?
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace estancia {

/// Friedman's test of the hypothesis that all k methods are equivalent in N tests, and the less conservative
/// statistic that Iman and Davenport derived from it.
struct FriedmanTest {
  double chiSquared = 0;                        ///< χ²_F, corrected for ties; as SciPy's friedmanchisquare
  std::size_t degrees = 0;                      ///< k − 1
  double p = 1;                                 ///< of χ²_F, by the χ² distribution
  double f = 0;                                 ///< F_F; infinite when all tests rank the methods alike
  std::size_t fDegrees = 0, fOtherDegrees = 0;  ///< k − 1 and (k − 1)(N − 1)
  /// Of F_F, by the F distribution, but at least the chance k!^(1 − N) that N tests rank alike by luck, which
  /// no outcome can be below: for a few tests that agree the distribution would say 0.
  double fP = 1;
  /// A sentence when there is nothing to test (one method, one test, all values equal); both p are 1 then.
  std::string undefined;
};

/// `tests[t][c]` is what method c reached in test t; whether smaller or larger is better does not matter.
///
/// With R_j the mean rank of method j, t the sizes of groups of equal values within a test:
///     χ²_F = 12 N / (k (k + 1)) Σ_j (R_j − (k + 1)/2)² / (1 − Σ (t³ − t) / (N (k³ − k)))
///     F_F = (N − 1) χ²_F / (N (k − 1) − χ²_F)
/// Friedman, J. Am. Stat. Assoc. 32 (1937) and Ann. Math. Stat. 11 (1940); Iman & Davenport, Commun. Stat. A9
/// (1980); Demšar, JMLR 7 (2006), 3.2.2 (whose χ²_F leaves ties uncorrected). The distributions are
/// approximations, fair from about N > 10 and k > 5 on (Demšar). Throws Error as meanRanks() does.
FriedmanTest friedmanTest(const std::vector<std::vector<double>>& tests);

}  // namespace estancia
