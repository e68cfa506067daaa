// SPDX-License-Identifier: Apache-2.0
#include "fuzz/map_patches.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {
namespace {

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct Finalize {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Finalize>;

Statement prepare(sqlite3* database, const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr);
  return Statement(statement);
}

std::vector<std::string> column(sqlite3* database, const std::string& sql) {
  std::vector<std::string> texts;
  const Statement rows = prepare(database, sql);
  while (rows && sqlite3_step(rows.get()) == SQLITE_ROW)
    texts.emplace_back(reinterpret_cast<const char*>(sqlite3_column_text(rows.get(), 0)));
  return texts;
}

std::string blob(sqlite3* database, const std::string& sql) {
  const Statement row = prepare(database, sql);
  if (!row || sqlite3_step(row.get()) != SQLITE_ROW) return {};
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(row.get(), 0));
  const auto count = static_cast<std::size_t>(sqlite3_column_bytes(row.get(), 0));
  return count == 0 ? "" : std::string(bytes, count);
}

/// The column, by its number, of a row, by its number; both wrap around.
void patch(sqlite3* database, const std::vector<std::string>& tables, std::string_view how) {
  if (how.size() < 4 || tables.empty()) return;
  const auto number = [&](std::size_t i) { return static_cast<unsigned char>(how[i]); };
  const std::string& table = tables[number(0) % tables.size()];
  const auto columns = column(database, fmt::format("SELECT name FROM pragma_table_info('{}')", table));
  const std::string& name = columns[number(1) % columns.size()];
  std::string_view value = how.substr(4);
  // Keys are columns that each table has, also those without row ids.
  const std::string row = fmt::format(
      "\"{0}\" = (SELECT \"{0}\" FROM {1} LIMIT 1 OFFSET {2} % max(1, (SELECT count(*) FROM {1})))",
      columns.front(), table, number(2));
  const int type = number(3) % 7;
  if (type == 5) {
    sqlite3_exec(database, fmt::format("DELETE FROM {} WHERE {}", table, row).c_str(), nullptr, nullptr,
                 nullptr);
    return;
  }
  std::string replaced;
  if (type == 6) {
    const std::string sql = fmt::format("SELECT \"{}\" FROM {} WHERE {}", name, table, row);
    value = replaced = withBytesReplaced(blob(database, sql), value);
  }
  const Statement update =
      prepare(database, fmt::format("UPDATE OR IGNORE {} SET \"{}\" = ?1 WHERE {}", table, name, row));
  if (!update) return;
  std::int64_t integer = 0;
  double real = 0;
  std::memcpy(&integer, value.data(), std::min(value.size(), sizeof integer));
  std::memcpy(&real, value.data(), std::min(value.size(), sizeof real));
  const int size = static_cast<int>(value.size());
  if (type == 0) sqlite3_bind_int64(update.get(), 1, integer);
  if (type == 1) sqlite3_bind_double(update.get(), 1, real);
  if (type == 2) sqlite3_bind_text(update.get(), 1, value.data(), size, SQLITE_STATIC);
  if (type == 3 || type == 6) sqlite3_bind_blob(update.get(), 1, value.data(), size, SQLITE_STATIC);
  sqlite3_step(update.get());
}

}  // namespace

std::filesystem::path patchedMap(const std::string& whole, std::string_view bytes) {
  std::filesystem::path path = inputFile("input.estancia", whole);
  sqlite3* opened = nullptr;
  sqlite3_open(path.c_str(), &opened);
  const std::unique_ptr<sqlite3, Close> database(opened);
  sqlite3_exec(opened,
               "PRAGMA synchronous=OFF; PRAGMA journal_mode=MEMORY; PRAGMA ignore_check_constraints=ON",
               nullptr, nullptr, nullptr);
  static const auto tables =
      column(opened, "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name");
  sqlite3_exec(opened, "BEGIN", nullptr, nullptr, nullptr);
  for (const std::string_view how : parts(bytes, 4)) patch(opened, tables, how);
  sqlite3_exec(opened, "COMMIT", nullptr, nullptr, nullptr);
  return path;
}

}  // namespace estancia::fuzz
