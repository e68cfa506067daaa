// Decompressed file: a file that was compressed as a whole (.db3.zstd), unpacked to where temporary files
// are. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

struct DecompressedFile {
  /// It has no name any more, and is gone when it is closed.
  FileBytes file;
  /// False when the compressed file was truncated or damaged, and this is its beginning.
  bool whole = false;
};

/// Zstandard. Messages about the result call it by the name of `compressed`. Throws Error: corruptFile when
/// not even the beginning can be used, tooLarge when it would take more than half of what is free where
/// temporary files are, fileUnwritable.
DecompressedFile decompressFile(const FileBytes& compressed);

}  // namespace estancia::ros
