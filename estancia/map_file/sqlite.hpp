// SQLite connection: database and statements with C++ lifetimes and Estancia's errors. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/pose.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace estancia::sqlite {

/// Why no more can be written and what to do, if `systemError` (an errno) is such a failure; else "".
std::string_view whyNoSpace(int systemError);

/// A connection to one database file (or to memory). Every failure becomes an Error that advises the user.
class Database {
 public:
  enum class Mode { memory, read, write };

  /// `path` names the file in messages, also when the database is in memory.
  Database(const std::filesystem::path& path, Mode mode);

  /// Runs statements that return nothing.
  void run(const std::string& sql);
  /// Runs one with parameters; see Statement.
  template <class... Values>
  void execute(std::string_view sql, const Values&... values) const;
  /// Runs statements whose failure does not matter (tidying up). Returns whether they succeeded.
  bool tryRun(const std::string& sql) noexcept;
  /// The single number that a query returns.
  std::int64_t number(std::string_view sql) const;
  /// The first column of all rows, but for negative numbers.
  std::vector<std::size_t> numbers(std::string_view sql) const;

  bool inTransaction() const;
  bool isReadOnly() const;
  /// How long to wait for a lock that another process holds.
  void waitForLocks(int milliseconds);

  sqlite3* handle() const { return handle_.get(); }
  const std::filesystem::path& path() const { return path_; }

  /// Throws the Error for SQLite's result code.
  [[noreturn]] void fail(int code) const;
  /// Throws Error (corruptFile); `detail` describes the inconsistency.
  template <class... Values>
  [[noreturn]] void failDamaged(fmt::format_string<Values...> detail, Values&&... values) const {
    failAsDamaged(fmt::format(detail, std::forward<Values>(values)...));
  }

 private:
  [[noreturn]] void failAsDamaged(const std::string& detail) const;
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  std::filesystem::path path_;
  bool inMemory_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement with its parameters. Columns count from 0.
class Statement {
 public:
  template <class... Values>
  Statement(const Database& database, std::string_view sql, const Values&... values)
      : database_(&database), statement_(prepare(database, sql)) {
    bindAll(values...);
  }

  /// Begins anew. Texts and bytes must live until it has run. NaN becomes NULL; a pose is seven values.
  template <class... Values>
  void bindAll(const Values&... values) {
    reset();
    [[maybe_unused]] int position = 0;
    (bindNext(position, values), ...);
  }
  /// Steps to the next row; false after the last.
  bool next();
  /// Runs to the end and resets: for INSERT, UPDATE, DELETE.
  void execute();
  template <class... Values>
  void executeWith(const Values&... values) {
    bindAll(values...);
    execute();
  }

  std::int64_t integer(int column) const;
  /// In [lowest, highest]; else throws Error (corruptFile), as the next ones do. `what` names it.
  std::int64_t number(int column, std::int64_t lowest, std::int64_t highest, const char* what) const;
  int node(int column, int lowest, const char* what) const;
  /// NULL becomes NaN.
  double real(int column) const;
  double finite(int column, const char* what) const;
  /// The columns x, y, z, qx, qy, qz, qw from this one on; absent where these are NULL or cannot be one.
  std::optional<Pose> pose(int column) const;
  std::string text(int column) const;
  /// Bytes as a text.
  std::string blob(int column) const;
  /// Valid until the next step.
  std::span<const std::byte> bytes(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void reset();
  static sqlite3_stmt* prepare(const Database& database, std::string_view sql);
  template <class Value>
  void bindNext(int& position, const Value& value) {
    bind(++position, value);
  }
  void bindNext(int& position, const Pose& pose);
  void bindNext(int& position, const std::optional<Pose>& pose);
  void bind(int position, std::int64_t value);
  void bind(int position, int value) { bind(position, static_cast<std::int64_t>(value)); }
  void bind(int position, std::size_t value) { bind(position, static_cast<std::int64_t>(value)); }
  void bind(int position, double value);
  void bind(int position, std::string_view text);
  void bind(int position, std::span<const std::byte> bytes);
  void bind(int position, std::span<const float> values) { bind(position, std::as_bytes(values)); }

  const Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

template <class... Values>
void Database::execute(std::string_view sql, const Values&... values) const {
  Statement(*this, sql, values...).execute();
}

/// Throws Error (corruptFile) where the database would calculate: generated columns, indexes and defaults
/// that are expressions, virtual tables.
void requirePlainSchema(const Database& database);

/// Whether the file has a table of this name.
bool hasTable(const Database& database, std::string_view name);

}  // namespace estancia::sqlite
