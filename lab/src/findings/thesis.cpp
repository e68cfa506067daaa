// SPDX-License-Identifier: Apache-2.0
#include "findings/thesis.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "estancia/files/csv.hpp"

namespace estancia::experiments {
std::string ThesisTable::Row::name() const {
  return fmt::format("{}", fmt::join(keys, ", "));
}

std::optional<double> ThesisTable::find(const std::vector<std::string>& rowKeys,
                                        const std::string& column) const {
  const auto c = std::find(columns.begin(), columns.end(), column);
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const Row& known) { return known.keys == rowKeys; });
  if (c == columns.end() || row == rows.end()) return std::nullopt;
  return row->values[static_cast<std::size_t>(c - columns.begin())];
}

ResultTable ThesisTable::resultTable(ResultTable head) const {
  if (head.columns.empty())
    for (const std::string& column : columns) head.columns.push_back({column});
  for (const Row& row : rows) head.rows.push_back({row.name(), row.values});
  return head;
}

ThesisTable readThesisTable(const std::string& csv, std::size_t keys) {
  ThesisTable table;
  std::istringstream stream(csv);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  io::forEachCsvRow(lines, "the thesis' table", [&](const io::CsvRow& csvRow) {
    const auto& cells = csvRow.cells;
    const auto values = cells.begin() + static_cast<std::ptrdiff_t>(keys);
    if (table.keys.empty()) {
      table.keys.assign(cells.begin(), values);
      table.columns.assign(values, cells.end());
      return;
    }
    auto& row = table.rows.emplace_back(ThesisTable::Row{{cells.begin(), values}, {}});
    for (auto cell = values; cell != cells.end(); ++cell)
      row.values.push_back(cell->empty() ? std::nullopt : std::optional(std::stod(*cell)));
  });
  return table;
}

}  // namespace estancia::experiments
