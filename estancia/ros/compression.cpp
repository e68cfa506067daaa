// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/compression.hpp"

#include <bzlib.h>
#include <fcntl.h>
#include <lz4frame.h>
#include <stdlib.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

/// Result of one call of a codec.
struct DecodeStep {
  std::size_t read = 0, written = 0;
  /// The end of a frame; another may follow.
  bool finished = false;
};

[[noreturn]] void failDamaged(std::string_view codec, std::string_view why) {
  fail(ErrorCode::corruptFile, "its {} data are damaged ({}); copy the file again", codec, why);
}

class Lz4Decoder {
 public:
  Lz4Decoder() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  }
  ~Lz4Decoder() { LZ4F_freeDecompressionContext(context_); }
  Lz4Decoder(const Lz4Decoder&) = delete;
  Lz4Decoder& operator=(const Lz4Decoder&) = delete;

  DecodeStep step(std::span<const std::byte> in, std::span<std::byte> out) {
    std::size_t read = in.size(), written = out.size();
    const std::size_t left = LZ4F_decompress(context_, out.data(), &written, in.data(), &read, nullptr);
    if (LZ4F_isError(left) != 0) failDamaged("lz4", LZ4F_getErrorName(left));
    return {read, written, left == 0};
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class Bz2Decoder {
 public:
  Bz2Decoder() { start(); }
  ~Bz2Decoder() { BZ2_bzDecompressEnd(&stream_); }
  Bz2Decoder(const Bz2Decoder&) = delete;
  Bz2Decoder& operator=(const Bz2Decoder&) = delete;

  DecodeStep step(std::span<const std::byte> in, std::span<std::byte> out) {
    if (ended_) {
      BZ2_bzDecompressEnd(&stream_);
      start();
    }
    // Blocks have at most 1 GiB.
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = reinterpret_cast<char*>(out.data());
    stream_.avail_out = static_cast<unsigned>(out.size());
    const int result = BZ2_bzDecompress(&stream_);
    if (result != BZ_OK && result != BZ_STREAM_END)
      failDamaged("bzip2", result == BZ_DATA_ERROR ? "wrong checksum" : "not bzip2");
    ended_ = result == BZ_STREAM_END;
    return {in.size() - stream_.avail_in, out.size() - stream_.avail_out, ended_};
  }

 private:
  void start() {
    stream_ = {};
    ended_ = false;
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  bz_stream stream_{};
  bool ended_ = false;
};

using ZstdContext = std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)>;
ZstdContext makeZstdContext() {
  ZstdContext context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  return context;
}

class ZstdDecoder {
 public:
  DecodeStep step(std::span<const std::byte> in, std::span<std::byte> out) {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    const std::size_t left = ZSTD_decompressStream(context_.get(), &to, &from);
    if (ZSTD_isError(left) != 0) failDamaged("Zstandard", ZSTD_getErrorName(left));
    return {from.pos, to.pos, left == 0};
  }

 private:
  ZstdContext context_ = makeZstdContext();
};

/// Grows with what arrives where the size is not known.
class OutputBytes {
 public:
  explicit OutputBytes(std::size_t capacity)
      : bytes_(std::make_shared_for_overwrite<std::byte[]>(capacity)), capacity_(capacity) {}
  std::span<std::byte> room() { return {bytes_.get() + used_, capacity_ - used_}; }
  void add(std::size_t written) { used_ += written; }
  std::size_t size() const { return used_; }
  void grow() {
    if (capacity_ >= maxBlockBytes)
      fail(ErrorCode::tooLarge, "more than {} bytes uncompressed; this program takes no more at once",
           maxBlockBytes);
    const std::size_t capacity = std::min<std::size_t>(capacity_ * 2, maxBlockBytes);
    auto larger = std::make_shared_for_overwrite<std::byte[]>(capacity);
    std::memcpy(larger.get(), bytes_.get(), used_);
    bytes_ = std::move(larger);
    capacity_ = capacity;
  }
  Payload payload() const { return {bytes_, {bytes_.get(), used_}}; }

 private:
  std::shared_ptr<std::byte[]> bytes_;
  std::size_t capacity_, used_ = 0;
};

/// The most that one byte can become. lz4: a byte of a length stands for 255. Zstandard: a block of 128 KiB
/// takes four bytes. bzip2: a block of 900 kB, whose runs stand for 51 times as much, takes some forty.
std::uint64_t largestRatio(Compression by) {
  return by == Compression::lz4 ? 255 : by == Compression::zstd ? 32768 : std::uint64_t{1} << 21U;
}

/// The size that a frame of Zstandard names, as far as it can be; else a guess [bytes].
std::size_t likelySize(const CompressedBytes& compressed) {
  const std::uint64_t stored = compressed.bytes.size();
  std::uint64_t likely = stored * 4;
  if (compressed.by == Compression::zstd) {
    const unsigned long long named = ZSTD_getFrameContentSize(compressed.bytes.data(), stored);
    const bool known = named != ZSTD_CONTENTSIZE_UNKNOWN && named != ZSTD_CONTENTSIZE_ERROR;
    if (known && named <= (stored + 16) * largestRatio(compressed.by)) likely = named;
  }
  return std::clamp<std::uint64_t>(likely, 4096, maxBlockBytes);
}

template <class Decoder>
Payload decompressBy(Decoder&& decoder, const CompressedBytes& compressed) {
  std::span<const std::byte> in = compressed.bytes;
  OutputBytes out(compressed.size ? *compressed.size : likelySize(compressed));
  bool finished = in.empty();
  try {
    while (!in.empty() || !finished) {
      if (out.room().empty() && !compressed.size) out.grow();
      const DecodeStep step = decoder.step(in, out.room());
      in = in.subspan(step.read);
      out.add(step.written);
      finished = step.finished;
      if (step.read == 0 && step.written == 0 && !(out.room().empty() && !compressed.size)) break;
    }
  } catch (const Error& error) {
    if (compressed.whole || error.code() == ErrorCode::tooLarge) throw;
  }
  const bool fits = finished && in.empty() && out.size() == compressed.size.value_or(out.size());
  if (compressed.whole && !fits)
    fail(ErrorCode::corruptFile, "it gives {}{} bytes instead of {}; copy the file again", out.size(),
         finished && in.empty() ? "" : " or other", compressed.size.value_or(0));
  return out.payload();
}

/// A file without a name in the folder of temporary files.
class AnonymousFile {
 public:
  AnonymousFile() {
    std::error_code error;
    folder_ = std::filesystem::temp_directory_path(error);
    std::string pattern = (folder_ / "estancia-bag-XXXXXX").string();
    file_ = error ? -1 : mkostemp(pattern.data(), O_CLOEXEC);
    if (file_ < 0) failWriting(error ? error.message() : std::strerror(errno));
    unlink(pattern.c_str());
    most_ = std::filesystem::space(folder_, error).available / 2;
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
           "with room, or decompress it with `zstd -d`",
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

  std::filesystem::path folder_;
  int file_ = -1;
  std::uint64_t size_ = 0, most_ = 0;
};

}  // namespace

Compression compressionOf(std::string_view name) {
  if (name.empty() || name == "none") return Compression::none;
  if (name == "lz4") return Compression::lz4;
  if (name == "bz2") return Compression::bz2;
  if (name == "zstd") return Compression::zstd;
  return Compression::unknown;
}

bool isZstd(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 4> magic{0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

Payload decompress(const CompressedBytes& compressed) {
  const std::uint64_t stored = compressed.bytes.size();
  if (compressed.size.value_or(0) > maxBlockBytes || stored > maxBlockBytes)
    fail(ErrorCode::tooLarge, "{} bytes, {} uncompressed; this program takes at most {} at once", stored,
         compressed.size.value_or(0), maxBlockBytes);
  if (compressed.whole && compressed.size.value_or(0) > (stored + 16) * largestRatio(compressed.by))
    fail(ErrorCode::corruptFile, "{} bytes cannot become {}; copy the file again", stored,
         compressed.size.value_or(0));
  switch (compressed.by) {
    case Compression::lz4:
      return decompressBy(Lz4Decoder(), compressed);
    case Compression::bz2:
      return decompressBy(Bz2Decoder(), compressed);
    case Compression::zstd:
      return decompressBy(ZstdDecoder(), compressed);
    default:
      fail(ErrorCode::unsupportedFile, "compressed in a way that is not known; known: lz4, bz2, zstd");
  }
}

DecompressedFile decompressFile(const FileBytes& compressed) {
  const ZstdContext context = makeZstdContext();
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
