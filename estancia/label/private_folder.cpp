#include "estancia/label/private_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kPrefix = "estancia-", kUnique = "XXXXXX";
constexpr const char* kLock = "estancia.lock";

/// As mkdtemp() makes them of our pattern.
bool isOurs(const std::string& name) {
  const auto isAlphanumeric = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  return name.starts_with(kPrefix) && name.size() == kPrefix.size() + kUnique.size() &&
         std::all_of(name.begin() + kPrefix.size(), name.end(), isAlphanumeric);
}

/// Whether the open file is this user's and of this type (S_IFDIR, S_IFREG).
bool isOwn(int file, mode_t type) {
  struct stat status {};
  return fstat(file, &status) == 0 && status.st_uid == geteuid() && (status.st_mode & S_IFMT) == type;
}

/// Removes the folder if it has a lock that nobody holds. Follows no symbolic link, enters no folder in it.
void removeIfAbandoned(const fs::path& folder) {
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (opened < 0) return;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(fdopendir(opened), closedir);
  if (!entries) ::close(opened);
  if (!entries || !isOwn(opened, S_IFDIR)) return;
  const int lock = openat(opened, kLock, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (lock < 0) return;
  if (isOwn(lock, S_IFREG) && flock(lock, LOCK_EX | LOCK_NB) == 0) {
    bool empty = true;
    while (const dirent* entry = readdir(entries.get())) {
      const std::string_view name = entry->d_name;
      if (name != "." && name != ".." && name != kLock)
        empty = unlinkat(opened, entry->d_name, 0) == 0 && empty;
    }
    if (empty && unlinkat(opened, kLock, 0) == 0) rmdir(folder.c_str());
  }
  ::close(lock);
}

void removeAbandonedIn(const fs::path& temporary) {
  std::error_code problem;
  for (fs::directory_iterator entry(temporary, problem), end; !problem && entry != end;
       entry.increment(problem))
    if (isOurs(entry->path().filename().string())) removeIfAbandoned(entry->path());
}

}  // namespace

PrivateFolder::PrivateFolder() {
  const fs::path temporary = fs::temp_directory_path();
  removeAbandonedIn(temporary);
  for (;;) {
    std::string pattern = (temporary / kPrefix).string().append(kUnique);
    const bool made = mkdtemp(pattern.data()) != nullptr;
    if (made)
      lock_ = ::open((fs::path(pattern) / kLock).c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (lock_ < 0) {
      const int why = errno;
      if (made) rmdir(pattern.c_str());
      fail(ErrorCode::fileUnwritable,
           "cannot make a folder for images ({}): {}; set TMPDIR to one that can be written",
           printable(pattern), std::strerror(why));
    }
    path_ = pattern;
    if (flock(lock_, LOCK_EX) != 0) {  // a file system without locks: never to be taken for abandoned
      unlink((path_ / kLock).c_str());
      return;
    }
    struct stat status {};
    if (fstat(lock_, &status) == 0 && status.st_nlink > 0) return;
    ::close(lock_);  // another process has taken it for abandoned before it was locked
    lock_ = -1;
  }
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

}  // namespace estancia
