// Map file's place on disk: what is tried before it is written, and how it takes its place. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia::sqlite {
class Database;
}

namespace estancia::storage {

/// A reader may hold a lock for a moment while it recovers [ms].
constexpr int lockPatience = 1000;

/// Throws Error: "PATH: why".
template <class... Values>
[[noreturn]] void refuse(const std::filesystem::path& path, ErrorCode code, fmt::format_string<Values...> why,
                         Values&&... values) {
  throw Error(code, path.string() + ": " + fmt::format(why, std::forward<Values>(values)...));
}
[[noreturn]] void failExists(const std::filesystem::path& path);

/// "." for a file that is named alone.
std::filesystem::path folderOf(const std::filesystem::path& path);

/// Throws unless a file of some size can be made in the folder: tried out, because permission bits do not
/// reflect full or read-only disks (nor to root).
void requireWritable(const std::filesystem::path& folder);
/// Throws unless the file is empty or begins as a map file, intact or not: nothing else is ever replaced.
void requireReplaceable(const std::filesystem::path& path);
/// Throws unless it is a file that may be a map.
void requireMapFile(const std::filesystem::path& path);

constexpr std::int64_t formatVersion = 6;
/// Throws unless it is a whole map of a format that can be read.
void requireOurFormat(const sqlite::Database& database);

/// Removes SQLite's companions of a file. Left behind, they would be applied to the next file of that name.
void removeCompanions(const std::filesystem::path& path);
/// Renames without ever replacing.
void renameToNew(const std::filesystem::path& from, const std::filesystem::path& to);
/// Puts the finished file `from` in the place of the map `to`. A map that a process is writing is refused.
void renameOver(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace estancia::storage
