// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

const char* nameOf(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "folder";
    case fs::file_type::fifo:
      return "pipe";
    case fs::file_type::socket:
      return "socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "device";
    default:
      return "special file";
  }
}

/// Prefix of the names of a target's part files: ".map.estancia.robot-1.".
std::string partStart(const fs::path& target) {
  // leaves room for host, process and SQLite's suffixes in the 255 allowed
  constexpr std::size_t longest = 160;
  std::array<char, 65> host{};
  gethostname(host.data(), host.size() - 1);
  return fmt::format(".{}.{}.", target.filename().string().substr(0, longest), host.data());
}

constexpr std::string_view partEnd = ".part";

/// Also of what lies beside a part file: ".part-wal".
bool isPartEnd(std::string_view text) {
  return text.starts_with(partEnd) && (text.size() == partEnd.size() || text[partEnd.size()] == '-');
}

/// Removes part files of processes that are no more.
void removeAbandoned(const fs::path& folder, const std::string& start) {
  std::error_code ignored;
  for (fs::directory_iterator at(folder, ignored), end; at != end; at.increment(ignored)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(start)) continue;
    pid_t process = 0;
    const char* last = name.data() + name.size();
    const auto [stop, wrong] = std::from_chars(name.data() + start.size(), last, process);
    if (wrong != std::errc() || process <= 0 || !isPartEnd({stop, last})) continue;
    if (kill(process, 0) == -1 && errno == ESRCH) fs::remove(at->path(), ignored);
  }
}

/// Waits until the disk has the file. Folders of some file systems, which cannot be synced, are as good.
std::error_code flushed(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  const int problem = fsync(file) == 0 ? 0 : errno;
  close(file);
  const bool isOfTheDisk = problem == EIO || problem == ENOSPC || problem == EDQUOT;
  return {isOfTheDisk ? problem : 0, std::generic_category()};
}

}  // namespace

fs::path outputTarget(const fs::path& path) {
  constexpr int maxLinks = 40;  // the kernel's limit
  std::error_code problem;
  const auto type = fs::status(path, problem).type();  // asks the kernel: links of /proc lead nowhere else
  if (type != fs::file_type::regular && type != fs::file_type::not_found && type != fs::file_type::none)
    fail(ErrorCode::fileUnwritable, "{} is a {}; give the name of a file to write", path.string(),
         nameOf(type));
  if (problem == std::errc::filename_too_long)
    fail(ErrorCode::fileUnwritable, "{} is too long a name ({}); give a shorter one", path.string(),
         problem.message());
  fs::path target = path;
  for (int links = 0; fs::is_symlink(target, problem); ++links) {
    if (links == maxLinks)
      fail(ErrorCode::fileUnwritable, "{} is a circular link; give another name", path.string());
    const fs::path next = fs::read_symlink(target, problem);
    if (problem)
      fail(ErrorCode::fileUnwritable, "{} is a link that cannot be read ({}); give another name",
           path.string(), problem.message());
    target = target.parent_path() / next;
  }
  return target;
}

fs::path partFile(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::string name = target.filename().string(), own = fmt::format(".{}{}", getpid(), partEnd);
  if (name.starts_with('.') && name.ends_with(own)) return folder / (name + "-first");
  const std::string start = partStart(target);
  removeAbandoned(folder, start);
  return folder / fmt::format("{}{}{}", start, getpid(), partEnd);
}

void flushToDisk(const fs::path& path) {
  if (const std::error_code problem = flushed(path))
    fail(ErrorCode::fileUnwritable, "{} cannot be written ({}); check the disk and its free space",
         path.string(), problem.message());
}

void writeWhole(const fs::path& path, std::string_view bytes) {
  const fs::path target = outputTarget(path), beside = partFile(target);
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code problem = file ? flushed(beside) : std::error_code(errno, std::generic_category());
  if (!problem) fs::rename(beside, target, problem);
  if (!problem) return;
  std::error_code ignored;
  fs::remove(beside, ignored);
  fail(ErrorCode::fileUnwritable, "{} cannot be written ({}); check the folder and the free disk space",
       path.string(), problem.message());
}

}  // namespace estancia
