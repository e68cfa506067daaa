// Clustering agreement: clusters against true classes (V-measure, Rand index, purity), and earlier clusters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace estancia {

/// Larger is better; all but the adjusted Rand index lie in [0, 1].
struct Agreement {
  /// 1 when every cluster has items of one class only.
  double homogeneity = 0;
  /// 1 when every class is in one cluster only.
  double completeness = 0;
  /// Harmonic mean of the two (Rosenberg and Hirschberg 2007, β = 1).
  double vMeasure = 0;
  /// Share of pairs that both treat alike, corrected for chance; at most 1 (Hubert and Arabie 1985).
  double adjustedRandIndex = 0;
  /// Share of the items that belong to their cluster's most frequent class.
  double purity = 0;
};

/// Compares two labelings of the same items; the label values are only names. A truth of one class is
/// homogeneous, one cluster is complete. Throws Error (invalidInput, mismatch) without items or for other
/// lengths. O(n log n).
Agreement measureAgreement(std::span<const int> truth, std::span<const int> clusters);

/// Agreement over the items whose class is known, by names.
struct NamedAgreement {
  /// Their number.
  std::size_t items = 0;
  /// Absent when there are none.
  std::optional<Agreement> agreement;
};

/// Items whose class is "" are left out. Throws Error (mismatch) when the lengths differ. O(n log n).
NamedAgreement measureNamedAgreement(std::span<const std::string> truth, std::span<const int> clusters);

/// How many members a new group shares with an earlier one.
using GroupOverlap = std::map<std::pair<std::size_t, std::size_t>, std::size_t>;

/// The number of each of `groups` new groups, 0 … groups − 1 without gaps: those of the earlier groups that
/// they overlap most, largest overlaps first, each once (greedy assignment). Earlier numbers beyond the last
/// one are lost. Groups without an earlier one get the free numbers, in order.
std::vector<std::size_t> keptNumbers(std::size_t groups, const GroupOverlap& overlap);

}  // namespace estancia
