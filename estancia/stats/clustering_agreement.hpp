// How well a clustering agrees with the truth.
#pragma once

#include <span>

namespace estancia {

/// All larger = better; all but the adjusted Rand index lie in [0, 1].
struct Agreement {
  double homogeneity = 0;   ///< 1 when every cluster holds one class only
  double completeness = 0;  ///< 1 when every class is in one cluster only
  double vMeasure = 0;      ///< harmonic mean of the two (Rosenberg and Hirschberg 2007, β = 1)
  /// Pairs judged alike, corrected for chance; at most 1 (Hubert and Arabie 1985)
  double adjustedRandIndex = 0;
  double purity = 0;  ///< share of the items that belong to their cluster's most frequent class
};

/// Compares two labelings of the same items; the label values are only names. A truth of one class is
/// homogeneous, one single cluster is complete. Throws Error when there are no items or the lengths differ.
/// O(n log n).
Agreement measureAgreement(std::span<const int> truth, std::span<const int> clusters);

}  // namespace estancia
