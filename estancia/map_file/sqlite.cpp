// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/sqlite.hpp"

#include <sqlite3.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "estancia/core/printable.hpp"
#include "estancia/map_file/store_files.hpp"

namespace estancia::sqlite {

using storage::refuse;

namespace {

/// Values larger than this in a file are taken for damage; bounds what SQLite allocates for a hostile file.
constexpr int maxValue = 256 << 20;

/// SQLite rolls back by the journal that it finds beside the map, and then deletes the file that the journal
/// names as super-journal, whichever that is (SQLite's file format, 3). Estancia attaches no other database,
/// so its journals name none. It would also wait for the writer of a pipe.
void requireOwnJournals(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code problem;
  const fs::path map = fs::canonical(path, problem);  // links are followed by SQLite, too
  if (problem) return;                                // it will report the problem
  for (const char* suffix : {"-journal", "-wal", "-shm"}) {
    const std::string beside = map.string() + suffix;
    const fs::file_status status = fs::symlink_status(beside, problem);
    if (fs::exists(status) && !fs::is_regular_file(status))
      refuse(beside, ErrorCode::unsupportedFile,
             "no regular file, but of this name is what a killed process leaves; remove it");
  }
  constexpr std::array<unsigned char, 8> superMagic{0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};
  const std::string journal = map.string() + "-journal";
  std::ifstream file(journal, std::ios::binary);
  std::array<char, superMagic.size()> last{};
  file.seekg(-static_cast<std::streamoff>(last.size()), std::ios::end);
  if (file.read(last.data(), last.size()) && std::memcmp(last.data(), superMagic.data(), last.size()) == 0)
    refuse(journal, ErrorCode::corruptFile,
           "names another file that is to be deleted, which Estancia never writes; do not use the map, or "
           "remove this file where you trust the rest");
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const {
  sqlite3_close_v2(handle);
}

Database::Database(const std::filesystem::path& path, Mode mode)
    : path_(path), inMemory_(mode == Mode::memory) {
  // Readers open for writing, too, where they may: only then can they recover and tidy up after a killed
  // writer. (SQLITE_OPEN_MEMORY is not wanted: VACUUM INTO would inherit it.)
  if (mode != Mode::memory) requireOwnJournals(path);
  const int flags = SQLITE_OPEN_READWRITE | (mode == Mode::memory ? SQLITE_OPEN_CREATE : 0);
  sqlite3* handle = nullptr;
  const std::string name = mode == Mode::memory ? std::string(":memory:") : path.string();
  const int code =
      sqlite3_open_v2(name.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, nullptr);
  handle_.reset(handle);
  if (handle == nullptr) refuse(path_, ErrorCode::tooLarge, "no memory to open the map");
  if (code != SQLITE_OK) fail(code);
  // The file may come from anywhere: its schema may run nothing, and cells are checked before they are used.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, maxValue);
  run("PRAGMA cell_size_check = ON; PRAGMA ignore_check_constraints = ON");
  if (mode == Mode::read) run("PRAGMA query_only = ON");
}

void Database::run(const std::string& sql) {
  const int code = sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

bool Database::tryRun(const std::string& sql) noexcept {
  return sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
}

std::int64_t Database::number(std::string_view sql) const {
  Statement statement(*this, sql);
  if (!statement.next()) failDamaged("a value is missing");
  return statement.integer(0);
}

std::vector<std::size_t> Database::numbers(std::string_view sql) const {
  std::vector<std::size_t> numbers;
  for (Statement rows(*this, sql); rows.next();)
    if (rows.integer(0) >= 0) numbers.push_back(static_cast<std::size_t>(rows.integer(0)));
  return numbers;
}

bool Database::inTransaction() const {
  return sqlite3_get_autocommit(handle()) == 0;
}

bool Database::isReadOnly() const {
  return sqlite3_db_readonly(handle(), "main") == 1;
}

void Database::waitForLocks(int milliseconds) {
  sqlite3_busy_timeout(handle(), milliseconds);
}

std::string_view whyNoSpace(int systemError) {
  if (systemError == EFBIG)
    return "the file would be larger than `ulimit -f` or its file system allows; raise the limit, or choose "
           "another disk";
  if (systemError == ENOSPC || systemError == EDQUOT) return "the disk is full; free some space";
  return {};
}

void Database::fail(int code) const {
  const int lastError = errno, primary = code & 0xff;
  const bool isWrite = code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_FSYNC ||
                       code == SQLITE_IOERR_TRUNCATE || code == SQLITE_IOERR_DIR_FSYNC;
  // SQLite keeps the system's error of statements, but not of their commit.
  const int kept = sqlite3_system_errno(handle()), systemError = kept == 0 && isWrite ? lastError : kept;
  const char* cause = systemError != 0 ? std::strerror(systemError) : sqlite3_errstr(code);
  const std::string_view noSpace = whyNoSpace(primary == SQLITE_FULL ? ENOSPC : systemError);
  if (primary == SQLITE_FULL || (primary == SQLITE_IOERR && !noSpace.empty()))
    refuse(path_, ErrorCode::fileUnwritable, "{}. {}", noSpace,
           inMemory_ ? "Nothing of the map was written; map again then"
                     : "Run the command again then. Maps are as of their last commit: `estancia map` goes on "
                       "by --continue, `estancia live` by itself");
  switch (primary) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      refuse(path_, ErrorCode::busy,
             "another process is writing this map; wait until it has ended, or end it");
    case SQLITE_READONLY:
      refuse(path_, ErrorCode::fileUnwritable,
             "the file or its folder is read-only; copy the map to a folder with write permission");
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_CANTOPEN:
      refuse(path_, ErrorCode::fileUnreadable,
             "cannot be opened ({}); check the permissions of the file and its folder. A map whose process "
             "was killed needs its -wal file beside it and write permission",
             cause);
    case SQLITE_NOTADB:
      refuse(path_, ErrorCode::unsupportedFile,
             "not a map file; give a file that `estancia map` has written");
    case SQLITE_NOMEM:
      refuse(path_, ErrorCode::tooLarge, "not enough memory for the map");
    case SQLITE_IOERR:
      if (code == SQLITE_IOERR_SHORT_READ) failDamaged("it ends too early");
      refuse(path_, isWrite ? ErrorCode::fileUnwritable : ErrorCode::fileUnreadable,
             "{} failed ({}); check the disk", isWrite ? "writing" : "reading or writing", cause);
  }
  failAsDamaged(sqlite3_errmsg(handle()));
}

void Database::failAsDamaged(const std::string& detail) const {
  refuse(path_, ErrorCode::corruptFile,
         "the map is damaged or cut off ({}); restore a copy or map the sequence again", printable(detail));
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

sqlite3_stmt* Statement::prepare(const Database& database, std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(database.handle(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) database.fail(code);
  return statement;
}

void Statement::bind(int position, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), position, value);
}

void Statement::bind(int position, double value) {
  sqlite3_bind_double(statement_.get(), position, value);
}

void Statement::bind(int position, std::string_view text) {
  const int code = sqlite3_bind_text64(statement_.get(), position, text.data() == nullptr ? "" : text.data(),
                                       text.size(), SQLITE_STATIC, SQLITE_UTF8);
  if (code != SQLITE_OK) database_->fail(code);
}

void Statement::bind(int position, std::span<const std::byte> bytes) {
  // An empty blob needs a pointer that is not null, else SQLite binds NULL.
  const void* data = bytes.empty() ? static_cast<const void*>("") : bytes.data();
  const int code = sqlite3_bind_blob64(statement_.get(), position, data, bytes.size(), SQLITE_STATIC);
  if (code == SQLITE_TOOBIG)
    refuse(database_->path(), ErrorCode::tooLarge, "a value of {} bytes is larger than a map can hold",
           bytes.size());
  if (code != SQLITE_OK) database_->fail(code);
}

bool Statement::next() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  sqlite3_reset(statement_.get());
  database_->fail(code);
}

void Statement::execute() {
  while (next()) {
  }
  reset();
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
}

void Statement::bindNext(int& position, const Pose& pose) {
  for (const double value : {pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz, pose.qw})
    bind(++position, value);
}

void Statement::bindNext(int& position, const std::optional<Pose>& pose) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  bindNext(position, pose.value_or(Pose{none, none, none, none, none, none, none}));
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::int64_t Statement::number(int column, std::int64_t lowest, std::int64_t highest,
                               const char* what) const {
  const std::int64_t value = integer(column);
  if (value < lowest || value > highest) database_->failDamaged("{} is {}", what, value);
  return value;
}

int Statement::node(int column, int lowest, const char* what) const {
  return static_cast<int>(number(column, lowest, std::numeric_limits<int>::max(), what));
}

double Statement::real(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL
             ? std::numeric_limits<double>::quiet_NaN()
             : sqlite3_column_double(statement_.get(), column);
}

double Statement::finite(int column, const char* what) const {
  const double value = real(column);
  if (!std::isfinite(value)) database_->failDamaged("{} is no number", what);
  return value;
}

std::optional<Pose> Statement::pose(int column) const {
  const Pose pose{real(column),     real(column + 1), real(column + 2), real(column + 3),
                  real(column + 4), real(column + 5), real(column + 6)};
  return pose.isPlausible() ? std::optional(pose) : std::nullopt;
}

std::string Statement::text(int column) const {
  const auto* characters = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return characters == nullptr ? std::string() : std::string(characters, size);
}

std::string Statement::blob(int column) const {
  const auto found = bytes(column);
  return {reinterpret_cast<const char*>(found.data()), found.size()};
}

std::span<const std::byte> Statement::bytes(int column) const {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return data == nullptr ? std::span<const std::byte>() : std::span(data, size);
}

void requirePlainSchema(const Database& database) {
  // Views and triggers are off, as are constraints.
  Statement found(
      database,
      "SELECT name FROM sqlite_master WHERE type = 'table' AND sql LIKE '%VIRTUAL%' UNION ALL "
      "SELECT t.name FROM sqlite_master t, pragma_table_xinfo(t.name) c WHERE t.type = 'table' AND "
      "t.sql NOT LIKE '%VIRTUAL%' AND (c.hidden > 1 OR c.dflt_value LIKE '%(%') UNION ALL "
      "SELECT i.name FROM sqlite_master i, pragma_index_xinfo(i.name) c WHERE i.type = 'index' AND "
      "(c.cid = -2 OR i.sql LIKE '%WHERE%')");
  if (found.next()) database.failDamaged("it would run what stands in its schema, in {}", found.text(0));
}

bool hasTable(const Database& database, std::string_view name) {
  return Statement(database, "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?1", name).next();
}

}  // namespace estancia::sqlite
