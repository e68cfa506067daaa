// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/decompressed_file.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;

/// A file without a name in the folder of temporary files.
class AnonymousFile {
 public:
  AnonymousFile() {
    std::error_code error;
    folder_ = fs::temp_directory_path(error);
    std::string pattern = (folder_ / "estancia-bag-XXXXXX").string();
    file_ = error ? -1 : mkostemp(pattern.data(), O_CLOEXEC);
    if (file_ < 0) failWriting(error ? error.message() : std::strerror(errno));
    unlink(pattern.c_str());
    most_ = fs::space(folder_, error).available / 2;
    if (error) failWriting(error.message());
  }
  ~AnonymousFile() {
    if (file_ >= 0) close(file_);
  }
  AnonymousFile(const AnonymousFile&) = delete;
  AnonymousFile& operator=(const AnonymousFile&) = delete;

  void append(std::span<const std::byte> bytes, const std::string& source) {
    if ((size_ += bytes.size()) > most_)
      fail(ErrorCode::tooLarge,
           "{}: uncompressed it is more than half of what is free in {} ({} bytes); set TMPDIR to a folder "
           "with "
           "room, or decompress it with `zstd -d`",
           source, folder_.string(), most_);
    while (!bytes.empty()) {
      const ssize_t count = write(file_, bytes.data(), bytes.size());
      if (count < 0 && errno != EINTR) failWriting(std::strerror(errno));
      if (count > 0) bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }
  std::uint64_t size() const { return size_; }
  FileBytes release(const std::string& name) { return {std::exchange(file_, -1), name}; }

 private:
  [[noreturn]] void failWriting(const std::string& why) const {
    fail(ErrorCode::fileUnwritable, "{}: {}; set TMPDIR to a folder that can be written and has room",
         folder_.string(), why);
  }

  fs::path folder_;
  int file_ = -1;
  std::uint64_t size_ = 0, most_ = 0;
};

}  // namespace

DecompressedFile decompressFile(const FileBytes& compressed) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  std::vector<std::byte> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  AnonymousFile file;
  std::size_t left = 1;
  for (std::uint64_t at = 0; at < compressed.size() && ZSTD_isError(left) == 0;) {
    const std::size_t count = std::min<std::uint64_t>(in.size(), compressed.size() - at);
    compressed.read(at, std::span(in).first(count));
    at += count;
    ZSTD_inBuffer from{in.data(), count, 0};
    ZSTD_outBuffer to{out.data(), out.size(), out.size()};
    // While bytes are left, or the output was full.
    while (ZSTD_isError(left) == 0 && (from.pos < from.size || to.pos == to.size)) {
      to.pos = 0;
      const std::size_t before = from.pos;
      left = ZSTD_decompressStream(context.get(), &to, &from);
      file.append(std::span(out).first(to.pos), compressed.name());
      if (to.pos == 0 && from.pos == before) break;
    }
  }
  if (file.size() == 0)
    fail(ErrorCode::corruptFile, "{}: compressed, but cut off or damaged; copy it again", compressed.name());
  return {file.release(compressed.name()), left == 0};
}

}  // namespace estancia::ros
