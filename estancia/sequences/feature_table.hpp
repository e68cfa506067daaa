// Feature table: image features computed elsewhere, one CSV line per image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/options.hpp"

namespace estancia {

/// Adjacent columns of one feature.
struct FeaturePart {
  std::string name;
  std::size_t first = 0, size = 1;
  bool operator==(const FeaturePart&) const = default;
};

/// Invariant: one row of `values` per frame; the columns are those of the parts, one part after the other.
struct FeatureTable {
  /// `room` is "" where the cell is empty.
  std::vector<Frame> frames;
  /// Frames of one group stay on one side of a split; one per frame, empty without such a column.
  std::vector<std::string> groups;
  std::vector<FeaturePart> parts;
  /// Names of the numeric columns.
  std::vector<std::string> columns;
  DescriptorMatrix values{0};
};

struct FeatureTableOptions {
  /// Columns that are no features: notes, or answers that a learner must not see. All must exist.
  std::vector<std::string> ignored;
};
OptionGroup declare(FeatureTableOptions& options);

/// Reads a CSV with a header. The column `room` (or `class`) is the place, `image` the frame's name (without
/// it: "line 2" …), `group` the group, such as a drive; all others except the ignored hold numbers. Adjacent
/// columns named by a stem and consecutive numbers (g0, g1 …) are one part, named by the stem; any other
/// column is a part of its own. Throws Error `FILE:LINE:COLUMN: …` (columns counted from 1) where a cell is
/// no finite number, and `FILE:LINE: …` on a wrong number of cells, a repeated header, repeated names and
/// wrong columns.
FeatureTable readFeatureTable(const std::filesystem::path& file, const FeatureTableOptions& options = {});

/// Whether the file is a CSV whose header has a column `room` or `class`: others hold labels, not numbers.
bool isFeatureTable(const std::filesystem::path& file);

}  // namespace estancia
