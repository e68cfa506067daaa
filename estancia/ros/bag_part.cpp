// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/bag_part.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <new>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::ros {
namespace {

// Three days at a thousand messages a second; more takes more memory than it is worth.
constexpr std::size_t maxMessages = 250'000'000;

// All blocks that are kept, but for the last used one [bytes]. Bags are read in order: a few are enough.
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

/// "pkg/msg/Type" → "pkg/Type".
std::string typeName(std::string_view type) {
  constexpr std::string_view messageFolder = "/msg/";
  std::string name = printable(type);
  if (const auto at = name.find(messageFolder); at != std::string::npos)
    name.replace(at, messageFolder.size(), "/");
  return name;
}

}  // namespace

std::uint32_t BagPart::topicNumber(std::string_view name, std::string_view type, std::string_view encoding) {
  BagTopic topic{printable(name), typeName(type), {}, printable(encoding), 0};
  if (topic.encodingName == "ros1") topic.encoding = Encoding::ros1;
  if (topic.encodingName == "cdr") topic.encoding = Encoding::cdr;
  const std::string key = topic.name + '\n' + topic.type + '\n' + topic.encodingName;
  const auto [found, added] = topicNumbers_.emplace(key, static_cast<std::uint32_t>(topics.size()));
  if (added) topics.push_back(std::move(topic));
  return found->second;
}

void BagPart::addPlace(const BagPlace& place) {
  if (places.size() >= maxMessages)
    fail(ErrorCode::tooLarge, "{}: more than {} messages; split the bag", name_, maxMessages);
  places.push_back(place);
}

void BagPart::warnOfUnknownTopics() {
  if (unknown_ > 0)
    warnings.push_back(fmt::format("{}: {} messages of unknown topics are left out", name_, unknown_));
}

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

std::uint32_t ChunkedPart::restart() {
  places.clear();
  blocks_.clear();
  const std::uint64_t size = blocks_.file().size();
  return blocks_.add({0, size, size, Compression::none, 0, true});
}

bool ChunkedPart::scanBlock(std::uint32_t number) {
  const BagBlock& block = blocks_[number];
  if (block.compression == Compression::none) {
    FileSource source(blocks_.file(), block.at, block.stored);
    return scanRecords(source, number);
  }
  const Payload bytes = blocks_.load(number);
  MemorySource source(bytes.bytes);
  return scanRecords(source, number);
}

void ChunkedPart::scanChunk(const BagBlock& chunk) {
  try {
    if (!scanBlock(blocks_.add(chunk)) && chunk.whole)
      fail(ErrorCode::corruptFile, "the chunk at byte {} holds other things than messages", chunk.at);
  } catch (const Error& error) {
    if (damagedChunks_++ == 0) firstDamage_ = error.what();
  }
}

void ChunkedPart::warnOfScan(bool isWhole, std::uint64_t at) {
  if (!isWhole)
    warnings.push_back(fmt::format(
        "{}: it is cut off or damaged at byte {}; what was whole of the {} bytes from there is used, "
        "the rest is missing",
        name_, at, blocks_.file().size() - at));
  if (damagedChunks_ > 0)
    warnings.push_back(
        fmt::format("{}: {} of its chunks are damaged; first: {}", name_, damagedChunks_, firstDamage_));
  warnOfUnknownTopics();
}

void ChunkedPart::failOfIndex(std::uint32_t block) const {
  fail(ErrorCode::corruptFile,
       "{}: the chunk at byte {} does not have the message that the index tells; copy the file again", name_,
       blocks_[block].at);
}

}  // namespace estancia::ros
