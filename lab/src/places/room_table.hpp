// Room table: the rooms of images from a CSV beside them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "findings/csv_table.hpp"

namespace estancia::experiments {

/// A CSV with a header and one line an image, matched with the frames of a sequence. Images are named by
/// their file's name, with or without its extension, or by the number in it; images without a line, and lines
/// without an image, are no error.
class RoomTable {
 public:
  /// Throws Error `FILE:LINE: …` when there is no such file, no such column, or a line has too many or too
  /// few cells.
  RoomTable(const std::filesystem::path& file, const std::string& imageColumn,
            const std::vector<Frame>& frames);

  /// The cells of one column, one a frame; "" where no line names it. Throws Error when there is no such
  /// column.
  std::vector<std::string> column(const std::string& name) const;

 private:
  CsvTable table_;
  /// The row of each frame, null where it has none.
  std::vector<const io::CsvRow*> lines_;
};

/// The number in a name of nothing but digits ("0012.png" → "12"), else the name without its extension.
std::string imageNumber(const std::string& name);

}  // namespace estancia::experiments
