// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/feature_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/frame_list.hpp"
#include "estancia/files/path_option.hpp"

namespace estancia {
namespace {

/// Positions of the columns.
struct Layout {
  std::vector<std::string> header;
  std::optional<std::size_t> room, image, group;
  std::vector<std::size_t> numbers;
};

/// "g12" → "g" and 12. Nothing without digits, or without anything before them.
std::optional<std::pair<std::string, std::uint64_t>> stemAndNumber(const std::string& name) {
  const auto last = name.find_last_not_of("0123456789");
  if (last == std::string::npos || last + 1 == name.size() || name.size() - last - 1 > 9) return std::nullopt;
  return std::pair{name.substr(0, last + 1), std::stoull(name.substr(last + 1))};
}

std::vector<FeaturePart> partsOf(const std::vector<std::string>& columns, const std::string& where) {
  std::vector<FeaturePart> parts;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto here = stemAndNumber(columns[c]);
    const auto before = c > 0 ? stemAndNumber(columns[c - 1]) : std::nullopt;
    if (here && before && here->first == before->first && here->second == before->second + 1) {
      parts.back().name = here->first;
      ++parts.back().size;
    } else {
      parts.push_back({columns[c], c, 1});
    }
  }
  std::set<std::string> names;
  for (const FeaturePart& part : parts)
    if (!names.insert(part.name).second)
      fail(ErrorCode::malformedFile,
           "{}: two parts are named {}; put the columns {}0, {}1 … next to each other, or rename some", where,
           part.name, part.name, part.name);
  return parts;
}

Layout readHeader(const std::vector<std::string>& cells, const FeatureTableOptions& options,
                  const std::string& where) {
  Layout layout{cells, {}, {}, {}, {}};
  std::set<std::string> names;
  for (const std::string& cell : cells) {
    if (cell.empty()) fail(ErrorCode::malformedFile, "{}: a column has no name", where);
    if (!names.insert(cell).second)
      fail(ErrorCode::malformedFile, "{}: two columns are named {}", where, io::printable(cell));
  }
  for (const std::string& name : options.ignored)
    if (!names.contains(name))
      fail(ErrorCode::unknownName, "{}: no column {} to ignore", where, io::printable(name));
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (std::ranges::find(options.ignored, cells[c]) != options.ignored.end()) continue;
    if (cells[c] == "room" || cells[c] == "class") {
      if (layout.room)
        fail(ErrorCode::malformedFile, "{}: both `room` and `class` are columns; ignore one of them", where);
      layout.room = c;
    } else if (cells[c] == "image") {
      layout.image = c;
    } else if (cells[c] == "group") {
      layout.group = c;
    } else {
      layout.numbers.push_back(c);
    }
  }
  if (!layout.room) fail(ErrorCode::malformedFile, "{}: no column `room` or `class`", where);
  if (layout.numbers.empty()) fail(ErrorCode::malformedFile, "{}: no numeric columns", where);
  return layout;
}

float numberIn(const io::CsvRow& row, std::size_t column, const Layout& layout, const std::string& where) {
  const std::string& cell = row.cells[column];
  const auto value = io::toNumber(cell);
  if (value && std::abs(*value) <= std::numeric_limits<float>::max()) return static_cast<float>(*value);
  fail(ErrorCode::malformedFile, "{}:{}: {} is \"{}\", {}; correct it, or ignore the column", where,
       column + 1, io::printable(layout.header[column]), io::printable(cell),
       value ? "not a finite number" : "not a number");
}

}  // namespace

OptionGroup declare(FeatureTableOptions& o) {
  OptionGroup group("feature-table", "How to read a CSV of image features.");
  group.add("ignored", io::asText(o.ignored), "Columns that are no features, separated by commas")
      .automatic("none");
  return group;
}

FeatureTable readFeatureTable(const std::filesystem::path& file, const FeatureTableOptions& options) {
  const std::string name = io::printable(file);
  FeatureTable table;
  std::optional<Layout> layout;
  io::UniqueNames names;
  std::vector<float> values;
  io::forEachCsvRow(file, [&](const io::CsvRow& row) {
    const std::string where = fmt::format("{}:{}", name, row.line);
    if (!layout) {
      layout = readHeader(row.cells, options, where);
      for (const std::size_t c : layout->numbers) table.columns.push_back(io::printable(row.cells[c]));
      table.parts = partsOf(table.columns, where);
      table.values = DescriptorMatrix(table.columns.size());
      return;
    }
    if (row.cells.size() != layout->header.size())
      fail(ErrorCode::malformedFile, "{}: {} cells instead of {}", where, row.cells.size(),
           layout->header.size());
    if (row.cells == layout->header)
      fail(ErrorCode::malformedFile, "{}: repeated header; keep one table per file", where);
    values.clear();
    for (const std::size_t c : layout->numbers) values.push_back(numberIn(row, c, *layout, where));
    std::string image =
        layout->image ? io::printable(row.cells[*layout->image]) : fmt::format("line {}", row.line);
    names.add(image, file, row.line);
    table.frames.push_back({std::move(image), {}, {}, io::printable(row.cells[*layout->room])});
    if (layout->group) table.groups.push_back(io::printable(row.cells[*layout->group]));
    table.values.append(values);
  });
  if (table.frames.empty())
    fail(ErrorCode::insufficientData, "{}: {}; write a header with `room`, then one line per image", name,
         layout ? "no lines below the header" : "empty file");
  return table;
}

bool isFeatureTable(const std::filesystem::path& file) {
  if (!io::hasSuffix(file, {".csv"})) return false;
  std::ifstream stream(file);
  constexpr std::size_t maxHeader = std::size_t{1} << 22;
  std::string header(maxHeader, '\0');
  stream.getline(header.data(), static_cast<std::streamsize>(maxHeader));
  std::istringstream cells(header.c_str());
  for (std::string cell; std::getline(cells, cell, ',');) {
    std::erase_if(cell, [](char c) { return c == '"' || c == ' ' || c == '\r'; });
    if (cell == "room" || cell == "class") return true;
  }
  return false;
}

}  // namespace estancia
