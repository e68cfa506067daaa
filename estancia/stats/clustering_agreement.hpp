// Clustering agreement: how well clusters agree with true classes (V-measure, adjusted Rand index, purity).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace estancia {

/// Larger is better; all but the adjusted Rand index lie in [0, 1].
struct Agreement {
  /// 1 when every cluster has items of one class only.
  double homogeneity = 0;
  /// 1 when every class is in one cluster only.
  double completeness = 0;
  /// Harmonic mean of the two (Rosenberg and Hirschberg 2007, β = 1).
  double vMeasure = 0;
  /// Share of pairs that both partitions treat alike, corrected for chance; at most 1 (Hubert and Arabie
  /// 1985).
  double adjustedRandIndex = 0;
  /// Share of the items that belong to their cluster's most frequent class.
  double purity = 0;
};

/// Compares two labelings of the same items; the label values are only names. A truth of one class is
/// homogeneous, one single cluster is complete. Throws Error (invalidInput, mismatch) when there are no items
/// or the lengths differ.
/// O(n log n).
Agreement measureAgreement(std::span<const int> truth, std::span<const int> clusters);

/// Agreement over the items whose class is known, by names.
struct NamedAgreement {
  /// How many those are.
  std::size_t items = 0;
  /// Absent when there are none.
  std::optional<Agreement> agreement;
};

/// Items whose class is "" are left out. Throws Error (mismatch) when the lengths differ. O(n log n).
NamedAgreement measureNamedAgreement(std::span<const std::string> truth, std::span<const int> clusters);

}  // namespace estancia
