// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/store_files.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "estancia/map_file/map.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"

namespace estancia::storage {

namespace fs = std::filesystem;
using sqlite::Database;

/// Has the same tables for places, but for drives; writing it makes it the newest.
constexpr std::int64_t oldestVersion = 4;

fs::path folderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

[[noreturn]] void failExists(const fs::path& path) {
  refuse(path, ErrorCode::fileExists,
         "exists already; give another name, or continue it by `estancia map --continue`");
}

void requireWritable(const fs::path& folder) {
  if (!fs::is_directory(folder))
    refuse(folder, ErrorCode::fileNotFound, "there is no such folder; make it first");
  std::string probe = (folder / ".estancia-XXXXXX").string();
  const int file = mkstemp(probe.data());
  int problem = file < 0 ? errno : 0;
  if (file >= 0) {
    unlink(probe.c_str());
    const std::array<char, 65536> room{};
    std::size_t left = room.size();
    while (left > 0 && problem == 0) {  // a short write does not report why; the next one does
      const ssize_t written = write(file, room.data(), left);
      if (written < 0)
        problem = errno;
      else
        left -= static_cast<std::size_t>(written);
    }
    close(file);
  }
  if (const std::string_view noSpace = sqlite::whyNoSpace(problem); !noSpace.empty())
    refuse(folder, ErrorCode::fileUnwritable, "{}", noSpace);
  if (problem != 0)
    refuse(folder, ErrorCode::fileUnwritable, "cannot write in this folder ({}); choose another one",
           std::strerror(problem));
}

void renameToNew(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
  if (errno == EEXIST) failExists(to);
  if (errno != EINVAL && errno != ENOSYS)
    refuse(to, ErrorCode::fileUnwritable, "cannot be made ({})", std::strerror(errno));
  if (fs::exists(fs::symlink_status(to))) failExists(to);  // a file system without that kind of rename
  fs::rename(from, to);
}

void removeCompanions(const fs::path& path) {
  for (const char* ending : {"-wal", "-shm", "-journal"}) {
    std::error_code ignored;
    fs::remove(path.string() + ending, ignored);
  }
}

void requireReplaceable(const fs::path& path) {
  if (fs::is_regular_file(path) && fs::file_size(path) == 0) return;
  if (!isMapFile(path))
    refuse(path, ErrorCode::unsupportedFile,
           "not a map file, so it is not replaced; give another name or remove it first");
}

void renameOver(const fs::path& from, const fs::path& to) {
  requireReplaceable(to);
  Database old(to, Database::Mode::write);
  old.waitForLocks(lockPatience);
  // Takes the old map's -wal in and away, then keeps writers out until its file has gone.
  if (!old.tryRun("PRAGMA journal_mode = DELETE") || !old.tryRun("BEGIN EXCLUSIVE")) {
    if (const int code = sqlite3_errcode(old.handle()); code == SQLITE_BUSY) old.fail(code);
    removeCompanions(to);  // the old map is damaged: no process can use it
  }
  fs::rename(from, to);
}

void requireMapFile(const fs::path& path) {
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (status.type() == fs::file_type::none)
    refuse(path, ErrorCode::fileUnreadable, "cannot be read ({})", problem.message());
  if (!fs::exists(status))
    refuse(path, ErrorCode::fileNotFound, "there is no such map; make one by `estancia map`");
  if (!fs::is_regular_file(status))
    refuse(path, ErrorCode::unsupportedFile, "not a regular file; give the *.estancia file of a map");
  constexpr std::uintmax_t smallest = 512;  // SQLite's smallest page
  if (const auto size = fs::file_size(path, problem); !problem && size < smallest)
    refuse(path, ErrorCode::truncatedFile,
           "only {} bytes long, too short for a map; restore a copy or map the sequence again", size);
}

void requireOurFormat(const Database& database) {
  const fs::path& path = database.path();
  if (database.number("PRAGMA application_id") != mapApplicationId)
    refuse(path, ErrorCode::unsupportedFile,
           "another program's SQLite file, not a map; give a file that `estancia map` has written");
  const std::int64_t version = database.number("PRAGMA user_version");
  if (version < 1) database.failDamaged("its format version is {}", version);
  if (version < oldestVersion || version > formatVersion)
    refuse(path, ErrorCode::unsupportedFile,
           "map format {}, but this Estancia reads map formats {} to {}; {}", version, oldestVersion,
           formatVersion, version < oldestVersion ? "map the sequence again" : "update Estancia");
  sqlite::requirePlainSchema(database);
  // SQLite notices missing pages, but fills up a cut last one. (With a -wal file the size may change.)
  std::error_code problem;
  const auto size = fs::file_size(database.path(), problem);
  const auto pageSize = static_cast<std::uintmax_t>(database.number("PRAGMA page_size"));
  if (!problem && size % pageSize != 0 && !fs::exists(path.string() + "-wal"))
    database.failDamaged("its last page is incomplete");
}

}  // namespace estancia::storage
