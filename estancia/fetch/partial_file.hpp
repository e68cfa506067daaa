// Partial file: a download that arrives piece by piece, over several runs if need be.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace estancia {

/// TARGET.part, and beside it TARGET.part.from, which records where the bytes came from. Both stay when the
/// work is broken off. Invariant: locked against other processes while the object lives.
class PartialFile {
 public:
  /// Opens what an earlier run left, or an empty file. Throws Error (fileUnwritable; busy: another process).
  explicit PartialFile(std::filesystem::path target);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  const std::filesystem::path& path() const { return part_; }
  std::uint64_t size() const { return size_; }

  /// Where the bytes came from, and their version of the file (an HTTP validator; "": the server gave none).
  const std::string& source() const { return source_; }
  const std::string& version() const { return version_; }

  /// Throws away what is there; the next bytes will be of `source` in this `version`.
  void restart(const std::string& source, const std::string& version);

  /// Throws Error when the disk is full; what fitted is kept.
  void append(std::string_view bytes);

  /// Makes it the target, in one step. Throws Error when that fails.
  void finish();

 private:
  std::filesystem::path target_, part_, from_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::string source_, version_;
};

}  // namespace estancia
