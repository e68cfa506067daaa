// A faulty disk, to be preloaded (LD_PRELOAD): calls that fail, and what a power cut would leave.
//   ESTANCIA_DISK=FOLDER        files below it are on the disk; all others are left alone
//   ESTANCIA_DISK_FAULT=OP:N    the N-th call of OP fails, and each later one: open (of a file that is made),
//   write,
//                               sync, rename; "OP:N:once": it alone
//   ESTANCIA_DISK_SYNCED=FOLDER keeps each file as it was when it was last synced
// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace {

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

std::string_view setting(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool isOnDisk(std::string_view path) {
  static const std::string_view disk = setting("ESTANCIA_DISK");
  return !disk.empty() && path.starts_with(disk);
}

std::string pathOf(int file) {
  std::array<char, PATH_MAX> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t size = readlink(link.c_str(), path.data(), path.size());
  return size > 0 ? std::string(path.data(), static_cast<std::size_t>(size)) : "";
}

/// Whether this call of `operation` on a file of the disk fails.
bool fails(std::string_view operation, std::string_view path, int reason) {
  static const std::string_view fault = setting("ESTANCIA_DISK_FAULT");
  static std::atomic<long> calls = 0;
  if (!fault.starts_with(operation) || fault.substr(operation.size(), 1) != ":" || !isOnDisk(path))
    return false;
  const long first = std::atol(fault.substr(operation.size() + 1).data()), call = ++calls;
  if (call < first || (call > first && fault.ends_with(":once"))) return false;
  errno = reason;
  return true;
}

/// Where a power cut would find the file of the disk; "" if not requested.
std::string syncedCopyOf(const std::string& path) {
  static const std::string_view to = setting("ESTANCIA_DISK_SYNCED");
  return to.empty() || !isOnDisk(path) ? "" : std::string(to) + path.substr(path.rfind('/'));
}

/// Copies the file, as it is now.
void keepSynced(int file) {
  const std::string path = pathOf(file), copy = syncedCopyOf(path);
  if (copy.empty()) return;
  const int from = next<int(const char*, int, ...)>("open")(path.c_str(), O_RDONLY | O_CLOEXEC);
  const int target = next<int(const char*, int, ...)>("open")((copy + ".new").c_str(),
                                                              O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  std::array<char, 65536> bytes{};
  for (ssize_t count = 0; from >= 0 && target >= 0 && (count = read(from, bytes.data(), bytes.size())) > 0;)
    next<ssize_t(int, const void*, std::size_t)>("write")(target, bytes.data(),
                                                          static_cast<std::size_t>(count));
  close(from);
  close(target);
  next<int(const char*, const char*)>("rename")((copy + ".new").c_str(),
                                                copy.c_str());  // whole, or as it was
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  std::va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  if ((flags & O_CREAT) != 0 && fails("open", path, ENOSPC)) return -1;
  return next<int(const char*, int, ...)>("open64")(path, flags, mode);
}

// Offsets have 64 bits in either.
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

FILE* fopen64(const char* path, const char* mode) {
  if (*mode != 'r' && fails("open", path, ENOSPC)) return nullptr;
  return next<FILE*(const char*, const char*)>("fopen64")(path, mode);
}

ssize_t write(int file, const void* bytes, std::size_t count) {
  if (fails("write", pathOf(file), ENOSPC)) return -1;
  return next<ssize_t(int, const void*, std::size_t)>("write")(file, bytes, count);
}

ssize_t writev(int file, const iovec* parts, int count) {
  if (fails("write", pathOf(file), ENOSPC)) return -1;
  return next<ssize_t(int, const iovec*, int)>("writev")(file, parts, count);
}

ssize_t pwrite64(int file, const void* bytes, std::size_t count, off64_t at) {
  if (fails("write", pathOf(file), ENOSPC)) return -1;
  return next<ssize_t(int, const void*, std::size_t, off64_t)>("pwrite64")(file, bytes, count, at);
}

int fsync(int file) {
  if (fails("sync", pathOf(file), EIO)) return -1;
  keepSynced(file);
  return next<int(int)>("fsync")(file);
}

int fdatasync(int file) {
  if (fails("sync", pathOf(file), EIO)) return -1;
  keepSynced(file);
  return next<int(int)>("fdatasync")(file);
}

// Removed files are no more: file systems write that down before any later sync.
int unlink(const char* path) {
  const auto remove = next<int(const char*)>("unlink");
  if (const std::string copy = syncedCopyOf(path); !copy.empty()) remove(copy.c_str());
  return remove(path);
}

int rename(const char* from, const char* to) {
  if (fails("rename", to, EIO)) return -1;
  return next<int(const char*, const char*)>("rename")(from, to);
}

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) {
  if (fails("rename", to, EIO)) return -1;
  return next<int(int, const char*, int, const char*, unsigned)>("renameat2")(fromFolder, from, toFolder, to,
                                                                              flags);
}
}
