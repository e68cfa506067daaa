// CSV (RFC 4180): quoted cells may hold commas, doubled quotes and line ends.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace estancia::io {

struct CsvRow {
  /// Where the row starts in the file, from 1.
  std::size_t line;
  std::vector<std::string> cells;
};

/// All rows but empty ones, without blanks around unquoted cells. Throws Error with an unclosed quote's line.
std::vector<CsvRow> readCsv(const std::filesystem::path& file);

/// Reads row by row: the cells of a large file need many times its size.
void forEachCsvRow(const std::filesystem::path& file, const std::function<void(CsvRow&)>& use);

/// Parses lines that are already in memory; `source` names them in messages.
void forEachCsvRow(const std::vector<std::string>& lines, std::string_view source,
                   const std::function<void(CsvRow&)>& use);

/// Position of a column in a header.
std::optional<std::size_t> findColumn(const std::vector<std::string>& header, std::string_view name);

/// `text` as one cell, in quotes where it needs them.
std::string csvCell(std::string_view text);

}  // namespace estancia::io
