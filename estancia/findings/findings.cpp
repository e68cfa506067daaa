// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings.hpp"

#include <fmt/format.h>

namespace estancia {

std::string cellText(const ResultTable::Column& column, const std::optional<double>& value) {
  if (!value) return "–";
  switch (column.form) {
    case ResultTable::Form::scientific:
      if (*value >= 0 && *value < 1e-300) return "< 1e-300";  // below what a number can hold, or nearly
      return fmt::format("{:.{}e}", *value, column.decimals);
    case ResultTable::Form::yesNo:
      return *value != 0 ? "yes" : "no";
    case ResultTable::Form::fixed:
      break;
  }
  return fmt::format("{:.{}f}", *value, column.decimals);
}

std::string bestText(const ResultTable& table, std::size_t c) {
  const ResultTable::Column& column = table.columns[c];
  if (column.best == ResultTable::Best::none || table.rows.size() < 2) return "";
  std::optional<double> best;
  for (const auto& row : table.rows) {
    const auto& value = row.values[c];
    if (value && (!best || (column.best == ResultTable::Best::smallest ? *value < *best : *value > *best)))
      best = value;
  }
  return best ? cellText(column, best) : "";
}

}  // namespace estancia
