// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/csv.hpp"

#include <algorithm>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {

void forEachCsvRow(const std::filesystem::path& file, const std::function<void(CsvRow&)>& use) {
  forEachCsvRow(readLines(file), printable(file), use);
}

void forEachCsvRow(const std::vector<std::string>& lines, std::string_view source,
                   const std::function<void(CsvRow&)>& use) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CsvRow row{i + 1, {}};
    std::string cell;
    bool quoted = false, inside = false;  // the cell started with a quote; inside of its quotes
    const auto finish = [&] {
      row.cells.push_back(quoted ? cell : std::string(trimmed(cell)));
      cell.clear();
      quoted = false;
    };
    for (std::size_t k = 0;; ++k) {
      if (k == lines[i].size()) {
        if (!inside) break;
        if (++i == lines.size())
          fail(ErrorCode::malformedFile, "{}:{}: this quote is not closed", source, row.line);
        cell += '\n';
        k = static_cast<std::size_t>(-1);  // continue with the next line
        continue;
      }
      const char c = lines[i][k];
      if (inside && c == '"' && k + 1 < lines[i].size() && lines[i][k + 1] == '"')
        cell += lines[i][++k];
      else if (inside)
        c == '"' ? void(inside = false) : void(cell += c);
      else if (c == ',')
        finish();
      else if (c == '"' && !quoted && trimmed(cell).empty())
        inside = quoted = (cell.clear(), true);
      else if (!quoted)
        cell += c;  // after a closing quote only blanks are valid: dropped
    }
    finish();
    if (row.cells.size() > 1 || !row.cells[0].empty()) use(row);
  }
}

std::vector<CsvRow> readCsv(const std::filesystem::path& file) {
  std::vector<CsvRow> rows;
  forEachCsvRow(file, [&](CsvRow& row) { rows.push_back(std::move(row)); });
  return rows;
}

std::optional<std::size_t> findColumn(const std::vector<std::string>& header, std::string_view name) {
  const auto found = std::find(header.begin(), header.end(), name);
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

std::string csvCell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos && trimmed(text).size() == text.size())
    return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + '"';
}

}  // namespace estancia::io
