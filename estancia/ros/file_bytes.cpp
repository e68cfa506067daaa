// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/file_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::ros {
namespace {

// Large enough that headers that lie close together are one read, small beside an image that is jumped over.
constexpr std::uint64_t windowBytes = 16384;

}  // namespace

FileBytes::FileBytes(const std::filesystem::path& path)
    // Without O_NONBLOCK a pipe would be waited for.
    : FileBytes(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), printable(path.string())) {}

FileBytes::FileBytes(int file, std::string name) : file_(file), name_(std::move(name)) {
  if (file_ < 0) {
    const int reason = errno;
    const bool missing = reason == ENOENT || reason == ENOTDIR;
    fail(missing ? ErrorCode::fileNotFound : ErrorCode::fileUnreadable, "{}: {}; check the path", name_,
         missing ? "no such file" : std::strerror(reason));
  }
  struct stat status {};
  if (fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(file_);
    fail(ErrorCode::unsupportedFile, "{}: no regular file; give a bag", name_);
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : file_(std::exchange(other.file_, -1)), name_(std::move(other.name_)), size_(other.size_) {}

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
  std::swap(file_, other.file_);
  name_.swap(other.name_);
  std::swap(size_, other.size_);
  return *this;
}

FileBytes::~FileBytes() {
  if (file_ >= 0) close(file_);
}

void FileBytes::read(std::uint64_t offset, std::span<std::byte> into) const {
  while (!into.empty()) {
    const ssize_t count = pread(file_, into.data(), into.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      fail(ErrorCode::fileUnreadable, "{}: it cannot be read at byte {} ({}); check the disk", name_, offset,
           std::strerror(errno));
    if (count == 0)
      fail(ErrorCode::truncatedFile, "{}: it ends at byte {}, before what its index tells; copy it again",
           name_, offset);
    offset += static_cast<std::uint64_t>(count);
    into = into.subspan(static_cast<std::size_t>(count));
  }
}

std::optional<std::string_view> FileSource::at(std::uint64_t offset, std::uint64_t count) {
  if (offset > size_ || count > size_ - offset) return std::nullopt;
  if (offset < windowAt_ || offset - windowAt_ > window_.size() ||
      count > window_.size() - (offset - windowAt_)) {
    window_.resize(std::min(std::max(count, windowBytes), size_ - offset));
    windowAt_ = offset;
    file_.read(begin_ + offset, window_);
  }
  return std::string_view(reinterpret_cast<const char*>(window_.data()) + (offset - windowAt_), count);
}

}  // namespace estancia::ros
