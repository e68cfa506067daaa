// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/sqlite_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <exception>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::ros {
namespace {

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

}  // namespace

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

}  // namespace estancia::ros
