// Bag part: one file of a bag, its topics, and its messages in blocks that are read when they are needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/ros/compression.hpp"
#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

/// Where a message is: 24 bytes, as bags have millions of them.
struct BagPlace {
  std::int64_t time = 0;
  /// In its block [bytes], or its number in a table.
  std::uint64_t offset = 0;
  std::uint32_t block = 0;
  /// Position in BagPart::topics.
  std::uint32_t topic = 0;
};

class BagPart {
 public:
  virtual ~BagPart() = default;
  /// Name of its file, for messages.
  const std::string& name() const { return name_; }

  /// In any order; their counts are not set.
  std::vector<BagTopic> topics;
  /// In any order.
  std::vector<BagPlace> places;
  std::vector<std::string> warnings;

  /// How many blocks places name.
  virtual std::uint32_t blocks() const = 0;
  /// Reads the payload as stored, perhaps compressed. Throws Error. Thread-safe.
  virtual Payload read(std::uint32_t block, std::uint64_t offset, std::uint32_t topic) const = 0;

 protected:
  explicit BagPart(std::string name) : name_(std::move(name)) {}
  /// The position of such a topic, which is added where it is new.
  std::uint32_t topicNumber(std::string_view name, std::string_view type, std::string_view encoding);
  /// Throws Error: tooLarge when there are too many.
  void addPlace(const BagPlace& place);
  void warnOfUnknownTopics();

  std::string name_;
  std::uint64_t unknown_ = 0;  ///< messages of unknown topics

 private:
  std::unordered_map<std::string, std::uint32_t> topicNumbers_;
};

/// Chunk of a file.
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
  /// All of these bytes, which keep no much larger block in memory. Throws Error: corruptFile.
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

/// A file of chunks, whose messages are found by its index, else by reading it through.
class ChunkedPart : public BagPart {
 public:
  std::uint32_t blocks() const final { return blocks_.count(); }

 protected:
  explicit ChunkedPart(FileBytes file) : BagPart(file.name()), blocks_(std::move(file)) {}
  /// Forgets what the index gave. Returns the number of a block that is the whole file.
  std::uint32_t restart();
  /// Adds the messages of a block; false where it holds other things.
  virtual bool scanRecords(ByteSource& source, std::uint32_t block) = 0;
  bool scanBlock(std::uint32_t block);
  /// Scans a chunk of a file without an index; a damaged one is counted.
  void scanChunk(const BagBlock& chunk);
  /// `isWhole`: the file is sound up to its end, else up to `at`.
  void warnOfScan(bool isWhole, std::uint64_t at);
  [[noreturn]] void failOfIndex(std::uint32_t block) const;

  BagBlocks blocks_;

 private:
  std::uint64_t damagedChunks_ = 0;
  std::string firstDamage_;
};

/// Throw Error when not even their beginning can be used.
std::unique_ptr<BagPart> openRos1Part(FileBytes file);
std::unique_ptr<BagPart> openMcapPart(FileBytes file);
std::unique_ptr<BagPart> openSqlitePart(FileBytes file);

}  // namespace estancia::ros
