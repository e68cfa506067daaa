// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/findings/thesis.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

namespace estancia::experiments {
namespace {

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == ',')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

}  // namespace

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
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    const auto cells = cellsOf(line);
    const auto values = cells.begin() + static_cast<std::ptrdiff_t>(keys);
    if (table.keys.empty()) {
      table.keys.assign(cells.begin(), values);
      table.columns.assign(values, cells.end());
      continue;
    }
    auto& row = table.rows.emplace_back(ThesisTable::Row{{cells.begin(), values}, {}});
    for (auto cell = values; cell != cells.end(); ++cell)
      row.values.push_back(cell->empty() ? std::nullopt : std::optional(std::stod(*cell)));
  }
  return table;
}

}  // namespace estancia::experiments
