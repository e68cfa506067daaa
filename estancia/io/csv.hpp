// Comma-separated values as RFC 4180 has them: quoted cells may hold commas, doubled quotes and line ends.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace estancia::io {

struct CsvRow {
  std::size_t line;  ///< where it starts in the file, from 1
  std::vector<std::string> cells;
};

/// All rows but empty ones; blanks around unquoted cells are dropped. Throws Error naming the line of an open
/// quote.
std::vector<CsvRow> readCsv(const std::filesystem::path& file);

/// The same, row by row: the cells of a large file take many times its size.
void forEachCsvRow(const std::filesystem::path& file, const std::function<void(CsvRow&)>& use);

/// `text` as one cell, in quotes where it needs them.
std::string csvCell(std::string_view text);

}  // namespace estancia::io
