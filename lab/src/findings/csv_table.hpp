// CSV table: rows under a header, with errors that name file and line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/files/csv.hpp"

namespace estancia::experiments {

class CsvTable {
 public:
  /// Throws Error (fileNotFound) without a file, (insufficientData) when it is empty, and (malformedFile)
  /// when two columns have one name or a row has more or fewer cells than the header.
  explicit CsvTable(std::filesystem::path file);

  /// The file's name, fit for messages.
  const std::string& name() const { return name_; }
  const std::filesystem::path& file() const { return file_; }
  /// Without the header.
  const std::vector<io::CsvRow>& rows() const { return rows_; }

  std::optional<std::size_t> find(const std::string& column) const;
  /// Throws Error (malformedFile) that lists the columns when there is none of this name.
  std::size_t column(const std::string& column) const;
  /// The cell of this column. Throws Error (malformedFile) when there is no such column, or nothing in it.
  const std::string& get(const io::CsvRow& row, const std::string& column) const;

  /// Throws Error (malformedFile) `FILE:LINE: why`.
  [[noreturn]] void fail(const io::CsvRow& row, const std::string& why) const;

 private:
  std::filesystem::path file_;
  std::string name_;
  io::CsvRow header_{1, {}};
  std::vector<io::CsvRow> rows_;
};

}  // namespace estancia::experiments
