// Bag blocks: the chunks of a file, read and decompressed when a message of theirs is asked for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/ros/compression.hpp"
#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

struct BagBlock {
  /// Its bytes in the file, and how many there are.
  std::uint64_t at = 0, stored = 0;
  /// Uncompressed [bytes].
  std::uint64_t size = 0;
  Compression compression = Compression::none;
  /// CRC-32 of the uncompressed bytes; 0: not known.
  std::uint32_t crc = 0;
  /// False for what the end of the file has cut: its beginning is read.
  bool whole = true;
};

/// Keeps the blocks that were used last. Reading is thread-safe.
class BagBlocks {
 public:
  explicit BagBlocks(FileBytes file) : file_(std::move(file)) {}

  const FileBytes& file() const { return file_; }
  /// Its number.
  std::uint32_t add(const BagBlock& block);
  const BagBlock& operator[](std::uint32_t block) const { return blocks_[block]; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(blocks_.size()); }
  void clear() { blocks_.clear(); }

  /// At most `most` bytes from `offset`; fewer where the block ends. Throws Error when the block is damaged.
  Payload read(std::uint32_t block, std::uint64_t offset, std::uint64_t most) const;
  /// All of these bytes; throws Error: corruptFile where the block has fewer. They keep no block in memory
  /// that is much larger than they are.
  Payload readAll(std::uint32_t block, std::uint64_t offset, std::uint64_t count) const;
  /// The whole block, not kept.
  Payload load(std::uint32_t block) const;

 private:
  struct Kept {
    std::uint32_t block;
    std::mutex loading;
    Payload bytes;
    /// Why it cannot be read: so that not each of its messages tries again.
    std::optional<Error> failure;
  };
  Payload kept(std::uint32_t block) const;
  bool isKept(const BagBlock& block) const;
  Payload loadUnnamed(const BagBlock& block) const;

  FileBytes file_;
  std::vector<BagBlock> blocks_;
  mutable std::mutex mutex_;
  /// The last used first.
  mutable std::list<std::shared_ptr<Kept>> kept_;
};

}  // namespace estancia::ros
