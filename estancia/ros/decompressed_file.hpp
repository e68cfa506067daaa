// Decompressed file: a file that was compressed as a whole (.db3.zstd), unpacked to where temporary files
// are. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

/// The file is gone when this is; who has opened it reads on.
class DecompressedFile {
 public:
  /// Zstandard. Throws Error: corruptFile when not even its beginning can be used, tooLarge when it would
  /// take more than half of what is free there, fileUnwritable.
  explicit DecompressedFile(const FileBytes& compressed);
  DecompressedFile(const DecompressedFile&) = delete;
  DecompressedFile& operator=(const DecompressedFile&) = delete;
  ~DecompressedFile();

  const std::filesystem::path& path() const { return path_; }
  /// False when the compressed file was truncated or damaged, and this is its beginning.
  bool whole() const { return whole_; }

 private:
  void unpack(const FileBytes& compressed, int file);

  std::filesystem::path path_;
  bool whole_ = false;
};

}  // namespace estancia::ros
