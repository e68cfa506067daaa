// Decompression: lz4 frames, bzip2 and Zstandard, as bags hold them, and whole files (.db3.zstd).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "estancia/ros/bag.hpp"
#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

enum class Compression { none, lz4, bz2, zstd, unknown };

/// "", "none", "lz4", "bz2", "zstd"; unknown for others.
Compression compressionOf(std::string_view name);

/// No chunk and no message is larger than this [bytes].
constexpr std::uint64_t maxBlockBytes = std::uint64_t{1} << 30U;

struct CompressedBytes {
  Compression by = Compression::none;
  std::span<const std::byte> bytes;
  /// Uncompressed, where it is known [bytes].
  std::optional<std::uint64_t> size;
  /// False for what was cut off, with no size: what its beginning gives is the result, even nothing.
  bool whole = true;
};

/// The messages of its Errors describe the compressed bytes only: corruptFile, tooLarge (more than
/// maxBlockBytes, or more than so few bytes can hold), unsupportedFile.
Payload decompress(const CompressedBytes& compressed);

/// Whether the bytes begin as Zstandard does.
bool isZstd(std::span<const std::byte> bytes);

/// A file that was compressed as a whole, unpacked to where temporary files are.
struct DecompressedFile {
  /// It has no name any more, and is gone when it is closed.
  FileBytes file;
  /// False when the compressed file was truncated or damaged, and this is its beginning.
  bool whole = false;
};

/// Zstandard; the result has the name of `compressed`. Throws Error: corruptFile when not even the beginning
/// can be used, tooLarge for more than half of what is free for temporary files, fileUnwritable.
DecompressedFile decompressFile(const FileBytes& compressed);

}  // namespace estancia::ros
