// SPDX-License-Identifier: Apache-2.0
#include "findings/csv_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/files/files.hpp"

namespace estancia::experiments {

CsvTable::CsvTable(std::filesystem::path file)
    : file_(std::move(file)), name_(io::printable(file_.string())), rows_(io::readCsv(file_)) {
  if (rows_.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: empty; write a first line that names the columns", name_));
  header_ = std::move(rows_.front());
  rows_.erase(rows_.begin());
  std::set<std::string> columns;
  for (const std::string& column : header_.cells)
    if (!column.empty() && !columns.insert(column).second)
      fail(header_, fmt::format("the column \"{}\" is repeated", io::printable(column)));
  for (const io::CsvRow& row : rows_)
    if (row.cells.size() != header_.cells.size())
      fail(row, fmt::format("{} cells instead of {}", row.cells.size(), header_.cells.size()));
}

std::optional<std::size_t> CsvTable::find(const std::string& column) const {
  const auto found = std::ranges::find(header_.cells, column);
  if (found == header_.cells.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.cells.begin());
}

std::size_t CsvTable::column(const std::string& column) const {
  const auto found = find(column);
  if (!found)
    fail(header_, fmt::format("no column \"{}\"; known: {}", io::printable(column),
                              io::printable(fmt::format("{}", fmt::join(header_.cells, ", ")))));
  return *found;
}

const std::string& CsvTable::get(const io::CsvRow& row, const std::string& name) const {
  const std::string& cell = row.cells[column(name)];
  if (cell.empty()) fail(row, fmt::format("the column \"{}\" is empty", io::printable(name)));
  return cell;
}

void CsvTable::fail(const io::CsvRow& row, const std::string& why) const {
  throw Error(ErrorCode::malformedFile, fmt::format("{}:{}: {}", name_, row.line, why));
}

}  // namespace estancia::experiments
