// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/bag_blocks.hpp"

#include <zlib.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <new>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

// All blocks that are kept, but for the last used one [bytes]. Bags are read in order: a few chunks are
// enough.
constexpr std::uint64_t keptBytes = std::uint64_t{64} << 20U;
constexpr std::size_t keptBlocks = 64;
// Larger blocks that need neither decompression nor a checksum are read message by message.
constexpr std::uint64_t largestKeptPlain = std::uint64_t{16} << 20U;
// A message is copied out of a block that is this many times as large.
constexpr std::uint64_t blocksPerMessage = 8;

Payload plainBytes(const FileBytes& file, std::uint64_t at, std::uint64_t count) {
  auto bytes = std::make_shared_for_overwrite<std::byte[]>(count);
  file.read(at, {bytes.get(), count});
  return {bytes, {bytes.get(), count}};
}

}  // namespace

std::uint32_t BagBlocks::add(const BagBlock& block) {
  if (blocks_.size() >= std::numeric_limits<std::uint32_t>::max())
    fail(ErrorCode::tooLarge, "{}: more than {} chunks; split the bag", file_.name(), blocks_.size());
  blocks_.push_back(block);
  return static_cast<std::uint32_t>(blocks_.size() - 1);
}

bool BagBlocks::isKept(const BagBlock& block) const {
  return block.compression != Compression::none || block.crc != 0 || block.stored <= largestKeptPlain;
}

Payload BagBlocks::loadUnnamed(const BagBlock& block) const {
  if (block.stored > maxBlockBytes || block.size > maxBlockBytes)
    fail(ErrorCode::tooLarge, "{} bytes, {} uncompressed; this program takes at most {} at once",
         block.stored, block.size, maxBlockBytes);
  Payload bytes = plainBytes(file_, block.at, block.stored);
  if (block.compression != Compression::none)
    bytes = decompress({block.compression, bytes.bytes,
                        block.whole ? std::optional(block.size) : std::nullopt, block.whole});
  if (block.crc == 0 || !block.whole) return bytes;
  const auto* data = reinterpret_cast<const Bytef*>(bytes.bytes.data());
  if (crc32_z(0, data, bytes.bytes.size()) != block.crc)
    fail(ErrorCode::corruptFile, "it is damaged, its checksum is another; copy the file again");
  return bytes;
}

Payload BagBlocks::load(std::uint32_t number) const {
  const BagBlock& block = blocks_[number];
  try {
    return loadUnnamed(block);
  } catch (const std::bad_alloc&) {
    fail(ErrorCode::tooLarge, "{}: the chunk at byte {} ({} bytes uncompressed) does not fit into the memory",
         file_.name(), block.at, block.size);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::truncatedFile || error.code() == ErrorCode::fileUnreadable) throw;
    fail(error.code(), "{}: the chunk at byte {}: {}", file_.name(), block.at, error.what());
  }
}

Payload BagBlocks::kept(std::uint32_t block) const {
  std::shared_ptr<Kept> found;
  {
    const std::lock_guard lock(mutex_);
    const auto at =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& k) { return k->block == block; });
    if (at != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, at);
    } else {
      kept_.push_front(std::make_shared<Kept>());
      kept_.front()->block = block;
      if (kept_.size() > keptBlocks) kept_.pop_back();
      std::uint64_t bytes = 0;
      for (auto k = std::next(kept_.begin()); k != kept_.end();)
        k = (bytes += blocks_[(*k)->block].size) > keptBytes ? kept_.erase(k) : std::next(k);
    }
    found = kept_.front();
  }
  // Other threads wait for this block only if they need it.
  const std::lock_guard lock(found->loading);
  if (found->failure) throw *found->failure;
  try {
    if (!found->bytes.owner) found->bytes = load(block);
  } catch (const Error& error) {
    found->failure = error;
    throw;
  }
  return found->bytes;
}

Payload BagBlocks::read(std::uint32_t number, std::uint64_t offset, std::uint64_t most) const {
  const BagBlock& block = blocks_[number];
  if (!isKept(block)) {
    if (offset >= block.stored) return {};
    return plainBytes(file_, block.at + offset, std::min(most, block.stored - offset));
  }
  Payload bytes = kept(number);
  if (offset >= bytes.bytes.size()) return {};
  bytes.bytes = bytes.bytes.subspan(offset, std::min<std::uint64_t>(most, bytes.bytes.size() - offset));
  return bytes;
}

Payload BagBlocks::readAll(std::uint32_t number, std::uint64_t offset, std::uint64_t count) const {
  Payload message = read(number, offset, count);
  if (message.bytes.size() != count)
    fail(ErrorCode::corruptFile, "{}: a message leaves its chunk, which is at byte {}; copy the file again",
         file_.name(), blocks_[number].at);
  if (!isKept(blocks_[number]) || count >= blocks_[number].size / blocksPerMessage) return message;
  auto copy = std::make_shared_for_overwrite<std::byte[]>(count);
  std::copy(message.bytes.begin(), message.bytes.end(), copy.get());
  return {copy, {copy.get(), count}};
}

}  // namespace estancia::ros
