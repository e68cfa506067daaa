// Pivot table: names down and across, one number where they meet.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/findings/findings.hpp"

namespace estancia::experiments {

using CellValue = std::optional<double>;

/// A column of each name.
std::vector<ResultTable::Column> columnsOf(const std::vector<std::string>& names, int decimals,
                                           ResultTable::Best best = ResultTable::Best::none);

/// Adds a row of each name to `head`, with value(row, column) under its columns.
ResultTable pivot(ResultTable head, const std::vector<std::string>& rows,
                  const std::function<CellValue(std::size_t row, std::size_t column)>& value);

/// A column, and what it shows of one of the items compared.
template <class Compared>
struct Measure {
  ResultTable::Column column;
  std::function<CellValue(const Compared&)> of;
};

/// A row of each item compared, a column of each measure; `head` has no columns yet.
template <class Compared>
ResultTable pivot(ResultTable head, const std::vector<std::pair<std::string, Compared>>& rows,
                  const std::vector<Measure<Compared>>& measures) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.push_back(row.first);
  for (const auto& measure : measures) head.columns.push_back(measure.column);
  return pivot(std::move(head), names,
               [&](std::size_t r, std::size_t c) { return measures[c].of(rows[r].second); });
}

/// The arithmetic mean; NaN of no values.
double meanOf(const std::vector<double>& values);

/// 0 … count − 1, the smallest key first; equal keys keep their order.
template <class Key>
std::vector<std::size_t> ascending(std::size_t count, const Key& key) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
  return order;
}

/// Their members `name`.
template <class Named>
std::vector<std::string> namesIn(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) names.push_back(one.name);
  return names;
}

}  // namespace estancia::experiments
