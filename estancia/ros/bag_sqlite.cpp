// rosbag2's SQLite storage: a table of topics and one of messages.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/ros/bag_part.hpp"

namespace estancia::ros {
namespace {

// Number of unreadable messages in a row after which the rest is given up.
constexpr sqlite3_int64 longestGap = sqlite3_int64{1} << 24U;

/// Ends what SQLite has given.
struct SqliteEnd {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using SqliteDatabase = std::unique_ptr<sqlite3, SqliteEnd>;
using Statement = std::unique_ptr<sqlite3_stmt, SqliteEnd>;
using Blob = std::unique_ptr<sqlite3_blob, SqliteEnd>;

/// A file for SQLite that is only read, and of which no part is ever made up: SQLite's own way of reading
/// takes bytes that are missing for zeros, and would write beside the file. This one takes it as immutable,
/// and without its last page where that is cut off.
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

/// SQLite's file object: its base, and the bytes behind it.
struct OpenSqliteFile {
  sqlite3_file base;
  const SqliteBytes* bytes;
};

const SqliteBytes& bytesOfFile(sqlite3_file* file) {
  return *reinterpret_cast<OpenSqliteFile*>(file)->bytes;
}

int closeSqliteFile(sqlite3_file*) {
  return SQLITE_OK;
}

int readSqliteFile(sqlite3_file* file, void* into, int count, sqlite3_int64 offset) {
  const SqliteBytes& bytes = bytesOfFile(file);
  const auto at = static_cast<std::uint64_t>(offset), wanted = static_cast<std::uint64_t>(count);
  const std::uint64_t there = std::min(wanted, bytes.size() - std::min(at, bytes.size()));
  std::memset(into, 0, wanted);
  try {
    bytes.file().read(at, {static_cast<std::byte*>(into), there});
  } catch (const std::exception&) {
    return SQLITE_IOERR_READ;
  }
  return there == wanted ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
}

int sizeOfSqliteFile(sqlite3_file* file, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(bytesOfFile(file).size());
  return SQLITE_OK;
}

const sqlite3_io_methods readOnlyFile = [] {
  sqlite3_io_methods methods{};
  methods.iVersion = 1;
  methods.xClose = closeSqliteFile;
  methods.xRead = readSqliteFile;
  methods.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
  methods.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
  methods.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
  methods.xFileSize = sizeOfSqliteFile;
  methods.xLock = [](sqlite3_file*, int) { return SQLITE_OK; };
  methods.xUnlock = [](sqlite3_file*, int) { return SQLITE_OK; };
  methods.xCheckReservedLock = [](sqlite3_file*, int* locked) { return *locked = 0, SQLITE_OK; };
  methods.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
  methods.xSectorSize = [](sqlite3_file*) { return 4096; };
  methods.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
  return methods;
}();

/// The database alone: no journal, nothing else.
int openSqliteFile(sqlite3_vfs* system, const char*, sqlite3_file* file, int flags, int* given) {
  file->pMethods = nullptr;
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return SQLITE_CANTOPEN;
  reinterpret_cast<OpenSqliteFile*>(file)->bytes = static_cast<const SqliteBytes*>(system->pAppData);
  file->pMethods = &readOnlyFile;
  if (given != nullptr) *given = SQLITE_OPEN_READONLY | SQLITE_OPEN_MAIN_DB;
  return SQLITE_OK;
}

/// The sizes of pages are written at byte 16, big-endian; 1 stands for 65,536.
std::uint64_t wholePages(const FileBytes& file) {
  std::array<std::byte, 2> bytes{};
  constexpr std::uint64_t smallest = 512;
  if (file.size() >= smallest) file.read(16, bytes);
  const auto written =
      std::to_integer<std::uint64_t>(bytes[0]) << 8U | std::to_integer<std::uint64_t>(bytes[1]);
  const std::uint64_t page = written == 1 ? 65536 : std::max(written, smallest);
  if (file.size() < page)
    fail(ErrorCode::malformedFile, "{}: only the beginning of an SQLite file; copy it again", file.name());
  return file.size() / page * page;
}

SqliteBytes::SqliteBytes(FileBytes file)
    : file_(std::move(file)),
      size_(wholePages(file_)),
      name_(fmt::format("estancia-bag-{}", static_cast<const void*>(this))) {
  const sqlite3_vfs* usual = sqlite3_vfs_find(nullptr);
  if (usual == nullptr) fail(ErrorCode::missingDependency, "SQLite has no files; install libsqlite3-0");
  system_ = *usual;  // for time and the like
  system_.pNext = nullptr;
  system_.zName = name_.c_str();
  system_.pAppData = this;
  system_.szOsFile = sizeof(OpenSqliteFile);
  system_.xOpen = openSqliteFile;
  system_.xDelete = [](sqlite3_vfs*, const char*, int) { return SQLITE_IOERR_DELETE; };
  system_.xAccess = [](sqlite3_vfs*, const char*, int, int* found) { return *found = 0, SQLITE_OK; };
  system_.xFullPathname = [](sqlite3_vfs*, const char* name, int most, char* full) {
    sqlite3_snprintf(most, full, "%s", name);
    return SQLITE_OK;
  };
  sqlite3_vfs_register(&system_, 0);
}

SqliteBytes::~SqliteBytes() {
  sqlite3_vfs_unregister(&system_);
}

SqliteDatabase SqliteBytes::open() const {
  sqlite3* opened = nullptr;
  const int result =
      sqlite3_open_v2("bag", &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, name_.c_str());
  SqliteDatabase database(opened);
  if (result != SQLITE_OK)
    fail(ErrorCode::malformedFile, "{}: SQLite cannot open it ({}); copy it again", file_.name(),
         printable(sqlite3_errstr(result)));
  return database;
}

std::string_view textAt(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? std::string_view() : std::string_view(text, sqlite3_column_bytes(row, column));
}

class SqlitePart final : public BagPart {
 public:
  explicit SqlitePart(FileBytes file) : BagPart(file.name()), bytes_(std::move(file)) {
    open();
    readTopics();
    readMessages();
  }

  std::uint32_t blocks() const override { return 1; }

  Payload read(std::uint32_t, std::uint64_t offset, std::uint32_t) const override {
    const std::lock_guard lock(mutex_);
    const auto id = static_cast<sqlite3_int64>(offset);
    int result = SQLITE_OK;
    if (blob_) {
      result = sqlite3_blob_reopen(blob_.get(), id);
    } else {
      sqlite3_blob* opened = nullptr;
      result = sqlite3_blob_open(database_.get(), "main", "messages", "data", id, 0, &opened);
      blob_.reset(opened);
    }
    if (result == SQLITE_OK) {
      const auto count = static_cast<std::size_t>(sqlite3_blob_bytes(blob_.get()));
      auto bytes = std::make_shared_for_overwrite<std::byte[]>(count);
      result = sqlite3_blob_read(blob_.get(), bytes.get(), static_cast<int>(count), 0);
      if (result == SQLITE_OK) return {bytes, {bytes.get(), count}};
    }
    // One that failed to open can never be used again.
    blob_.reset();
    const bool shorter = result == SQLITE_IOERR;
    fail(shorter ? ErrorCode::truncatedFile : ErrorCode::corruptFile,
         "{}: message {} cannot be read ({}); copy the file again", name_, id,
         shorter ? "the file has become shorter" : sqlite3_errstr(result));
  }

 private:
  void open() {
    database_ = bytes_.open();
    sqlite3* opened = database_.get();
    sqlite3_extended_result_codes(opened, 0);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(maxBlockBytes));
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    run("PRAGMA cell_size_check = ON");
    if (sqlite3_exec(opened, "SELECT 1 FROM sqlite_master", nullptr, nullptr, nullptr) == SQLITE_CORRUPT) {
      // SQLite does not open a file that is shorter than its header declares, unless one is about to mend it.
      sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);
      run("PRAGMA writable_schema = ON");
      warnings.push_back(fmt::format("{}: it is cut off or damaged; what can be read of it is used", name_));
    }
  }

  void run(const char* sql) { sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr); }

  Statement prepare(const char* sql) const {
    sqlite3_stmt* made = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &made, nullptr) != SQLITE_OK) failOpening();
    return Statement(made);
  }

  void readTopics() {
    // A view, a virtual table or a column that is computed would run what a stranger wrote.
    const Statement tables = prepare(
        "SELECT count(*) FROM sqlite_master AS t WHERE type = 'table' AND name IN ('topics', 'messages')"
        " AND sql LIKE 'CREATE TABLE%'"
        " AND NOT EXISTS (SELECT 1 FROM pragma_table_xinfo(t.name) WHERE hidden > 0)");
    if (sqlite3_step(tables.get()) != SQLITE_ROW) failOpening();
    if (sqlite3_column_int(tables.get(), 0) != 2)
      fail(ErrorCode::unsupportedFile, "{}: an SQLite file without rosbag2's tables; give a bag", name_);
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
    int result = SQLITE_OK;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW)
      topicOfId_.emplace(sqlite3_column_int64(rows.get(), 0),
                         topicNumber(textAt(rows.get(), 1), textAt(rows.get(), 2), textAt(rows.get(), 3)));
    if (result == SQLITE_DONE) return;
    if (topics.empty()) failOpening();
    warnings.push_back(
        fmt::format("{}: its table of topics is damaged; {} were found", name_, topics.size()));
  }

  void readMessages() {
    const Statement rows =
        prepare("SELECT rowid, topic_id, timestamp FROM messages WHERE rowid > ?1 ORDER BY rowid");
    sqlite3_int64 last = 0, skip = 0;
    std::uint64_t gaps = 0;
    int result = SQLITE_OK;
    // A damaged page is jumped over, however many messages it held.
    for (; result != SQLITE_DONE && skip < longestGap; skip = skip == 0 ? 1 : skip * 2) {
      sqlite3_reset(rows.get());
      sqlite3_bind_int64(rows.get(), 1, last + skip);
      while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
        const sqlite3_int64 id = sqlite3_column_int64(rows.get(), 0);
        // A page that is its own child would go round forever.
        if (id <= last || id > std::numeric_limits<sqlite3_int64>::max() - longestGap) break;
        last = id;
        skip = 0;
        const auto topic = topicOfId_.find(sqlite3_column_int64(rows.get(), 1));
        if (topic == topicOfId_.end())
          ++unknown_;
        else
          addPlace({sqlite3_column_int64(rows.get(), 2), static_cast<std::uint64_t>(id), 0, topic->second});
      }
      if (result != SQLITE_DONE && skip == 0) ++gaps;
    }
    if (gaps > 0)
      warnings.push_back(
          fmt::format("{}: pages of it are damaged or missing, and the messages on them: {} were found",
                      name_, places.size()));
    warnOfUnknownTopics();
  }

  [[noreturn]] void failOpening() const {
    const int code = sqlite3_errcode(database_.get());
    const bool damaged = code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
    fail(damaged ? ErrorCode::malformedFile : ErrorCode::unsupportedFile,
         "{}: no bag of rosbag2, or damaged ({}); copy the file again", name_,
         printable(sqlite3_errmsg(database_.get())));
  }

  SqliteBytes bytes_;
  SqliteDatabase database_;
  mutable std::mutex mutex_;
  mutable Blob blob_;
  std::unordered_map<sqlite3_int64, std::uint32_t> topicOfId_;
};
}  // namespace

std::unique_ptr<BagPart> openSqlitePart(FileBytes file) {
  return std::make_unique<SqlitePart>(std::move(file));
}

}  // namespace estancia::ros
