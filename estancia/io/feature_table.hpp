// Numbers that others computed of images: one CSV, a line an image.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"

namespace estancia {

/// Columns that belong together.
struct FeaturePart {
  std::string name;
  std::size_t first = 0, size = 1;  ///< of its columns
  bool operator==(const FeaturePart&) const = default;
};

/// Invariant: a row of `values` a frame; the columns are those of the parts, one part after the other.
struct FeatureTable {
  std::vector<Frame> frames;        ///< `room` is "" where the cell is empty
  std::vector<std::string> groups;  ///< what must not be torn apart, one a frame; none without such a column
  std::vector<FeaturePart> parts;
  std::vector<std::string> columns;  ///< the names of the numbers
  DescriptorMatrix values{0};
};

struct FeatureTableOptions {
  /// Columns that are no features: notes, or answers that a learner must not see, as the objects in the CSV
  /// of RobotVision. All must be there.
  std::vector<std::string> ignored;
};

/// Reads a CSV with a header. The column `room` (or `class`) says the place, `image` the frame's name
/// (without it: "line 2" …), `group` what belongs together, such as a drive; all others but the ignored hold
/// numbers. Neighboring columns whose names are a stem and running numbers (g0, g1 …) are one part, called
/// by the stem; any other column is a part of its own. Throws Error `FILE:LINE:COLUMN: …` (columns counted
/// from 1) where a cell is no finite number, and `FILE:LINE: …` where a line has too many or too few cells,
/// the header is there again, a name comes twice or the columns are not what they must be.
FeatureTable readFeatureTable(const std::filesystem::path& file, const FeatureTableOptions& options = {});

}  // namespace estancia
