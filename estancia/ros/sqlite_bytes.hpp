// SQLite bytes: SQLite's access to a file that is only read, and of which no part is ever made up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sqlite3.h>

#include <memory>

#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

struct CloseSqlite {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
using SqliteDatabase = std::unique_ptr<sqlite3, CloseSqlite>;

/// SQLite's own way of reading takes bytes that are missing for zeros, and would write beside the file. This
/// one takes it as immutable, and without its last page where that is cut off.
class SqliteBytes {
 public:
  explicit SqliteBytes(FileBytes file);
  SqliteBytes(const SqliteBytes&) = delete;
  SqliteBytes& operator=(const SqliteBytes&) = delete;
  ~SqliteBytes();

  const FileBytes& file() const { return file_; }
  /// Whole pages [bytes].
  std::uint64_t size() const { return size_; }
  /// Closed before this is gone. Throws Error: malformedFile.
  SqliteDatabase open() const;

 private:
  FileBytes file_;
  std::uint64_t size_;
  std::string name_;
  sqlite3_vfs system_{};
};

}  // namespace estancia::ros
