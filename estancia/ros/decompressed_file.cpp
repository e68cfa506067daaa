// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/decompressed_file.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;

void writeAll(int file, std::span<const std::byte> bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      fail(ErrorCode::fileUnwritable, "{}: {}; set TMPDIR to a folder with room", path.string(),
           std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace

DecompressedFile::DecompressedFile(const FileBytes& compressed) {
  std::string pattern = (fs::temp_directory_path() / "estancia-bag-XXXXXX").string();
  const int file = mkostemp(pattern.data(), O_CLOEXEC);
  if (file < 0)
    fail(ErrorCode::fileUnwritable, "{}: {}; set TMPDIR to a folder that can be written", pattern,
         std::strerror(errno));
  path_ = pattern;
  try {
    unpack(compressed, file);
  } catch (...) {
    close(file);
    unlink(path_.c_str());
    throw;
  }
  close(file);
}

DecompressedFile::~DecompressedFile() {
  unlink(path_.c_str());
}

void DecompressedFile::unpack(const FileBytes& compressed, int file) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  const std::uint64_t most = fs::space(path_.parent_path()).available / 2;
  std::vector<std::byte> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  std::uint64_t written = 0;
  std::size_t left = 1;
  for (std::uint64_t at = 0; at < compressed.size();) {
    const std::size_t count = std::min<std::uint64_t>(in.size(), compressed.size() - at);
    compressed.read(at, std::span(in).first(count));
    at += count;
    ZSTD_inBuffer from{in.data(), count, 0};
    std::size_t given = 0;
    do {
      ZSTD_outBuffer to{out.data(), out.size(), 0};
      left = ZSTD_decompressStream(context.get(), &to, &from);
      if (ZSTD_isError(left) != 0) {
        if (written == 0)
          fail(ErrorCode::corruptFile, "{}: damaged ({}); copy it again", compressed.name(),
               ZSTD_getErrorName(left));
        return;
      }
      given = to.pos;
      written += given;
      if (written > most)
        fail(ErrorCode::tooLarge,
             "{}: uncompressed it is more than half of what is free in {} ({} bytes); set TMPDIR to a folder "
             "with room, or decompress it with `zstd -d`",
             compressed.name(), path_.parent_path().string(), most);
      writeAll(file, std::span(out).first(given), path_);
    } while (from.pos < from.size || given == out.size());
  }
  whole_ = left == 0;
}

}  // namespace estancia::ros
