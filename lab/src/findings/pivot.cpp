// SPDX-License-Identifier: Apache-2.0
#include "findings/pivot.hpp"

namespace estancia::experiments {

std::vector<ResultTable::Column> columnsOf(const std::vector<std::string>& names, int decimals,
                                           ResultTable::Best best) {
  std::vector<ResultTable::Column> columns;
  for (const std::string& name : names) columns.push_back({name, decimals, best});
  return columns;
}

ResultTable pivot(ResultTable head, const std::vector<std::string>& rows,
                  const std::function<CellValue(std::size_t row, std::size_t column)>& value) {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    auto& row = head.rows.emplace_back(ResultTable::Row{rows[r], {}});
    for (std::size_t c = 0; c < head.columns.size(); ++c) row.values.push_back(value(r, c));
  }
  return head;
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace estancia::experiments
