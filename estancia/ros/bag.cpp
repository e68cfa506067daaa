// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/ros/bag_files.hpp"
#include "estancia/ros/bag_part.hpp"
#include "estancia/ros/compression.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<BagPart> openPlainPart(FileBytes file) {
  const auto format = bagFormat(file);
  if (format == BagFormat::ros1) return openRos1Part(std::move(file));
  if (format == BagFormat::mcap) return openMcapPart(std::move(file));
  if (format == BagFormat::sqlite) return openSqlitePart(std::move(file));
  fail(ErrorCode::unsupportedFile, "{}: no bag; give a .bag (2.0), .db3 or .mcap file", file.name());
}

std::unique_ptr<BagPart> openPart(const fs::path& path) {
  FileBytes file(path);
  std::vector<std::string> warnings;
  // rosbag2's files lack what SQLite keeps beside them until they are closed.
  std::error_code none;
  if (fs::file_size(path.string() + "-wal", none) > 0 && !none)
    warnings.push_back(
        fmt::format("{}: its last messages are in {}-wal and not read; `sqlite3 {} 'pragma "
                    "wal_checkpoint'` moves them in",
                    file.name(), file.name(), file.name()));
  if (bagFormat(file) == BagFormat::zstd) {
    DecompressedFile plain = decompressFile(file);
    if (!plain.whole)
      warnings.push_back(
          fmt::format("{}: it is cut off or damaged; what its beginning gives is used", file.name()));
    file = std::move(plain.file);
  }
  auto part = openPlainPart(std::move(file));
  part->warnings.insert(part->warnings.begin(), warnings.begin(), warnings.end());
  return part;
}

/// The files of a bag as one.
class PartsBag : public Bag {
 public:
  PartsBag(std::vector<std::unique_ptr<BagPart>> parts, std::vector<std::string> warnings)
      : parts_(std::move(parts)) {
    warnings_ = std::move(warnings);
    mergeTopics();
    warnOfOverlaps();
    mergeMessages();
  }

  Payload read(std::size_t message) const override {
    if (message >= messages_.size())
      fail(ErrorCode::invalidInput, "message {} of a bag of {}", message, messages_.size());
    const std::uint32_t block = blocks_[message];
    const auto next = std::upper_bound(firstBlock_.begin(), firstBlock_.end(), block);
    const auto part = static_cast<std::size_t>(next - firstBlock_.begin()) - 1;
    const std::uint32_t topic = messages_[message].topic;
    const auto local =
        std::find(topicOf_[part].begin(), topicOf_[part].end(), topic) - topicOf_[part].begin();
    Payload payload =
        parts_[part]->read(block - firstBlock_[part], offsets_[message], static_cast<std::uint32_t>(local));
    // No CDR begins so: rosbag2 has compressed it, as its metadata.yaml would show.
    if (topics_[topic].encoding != Encoding::cdr || !isZstd(payload.bytes)) return payload;
    try {
      return decompress({Compression::zstd, payload.bytes, {}, true});
    } catch (const Error& error) {
      fail(error.code(), "{}: message {}, of {}: {}", parts_[part]->name(), message, topics_[topic].name,
           error.what());
    }
  }

 private:
  void mergeTopics();
  void warnOfOverlaps();
  void mergeMessages();

  std::vector<std::unique_ptr<BagPart>> parts_;
  /// First block of each part, and its topics, in the numbering of the whole bag.
  std::vector<std::uint32_t> firstBlock_;
  std::vector<std::vector<std::uint32_t>> topicOf_;
  /// Block of each message.
  std::vector<std::uint32_t> blocks_;
  std::vector<std::uint64_t> offsets_;
};

void PartsBag::mergeTopics() {
  std::map<std::tuple<std::string, std::string, std::string>, std::uint32_t> numbers;
  for (const auto& part : parts_)
    for (const BagTopic& topic : part->topics)
      if (numbers.emplace(std::tuple(topic.name, topic.type, topic.encodingName), 0).second)
        topics_.push_back(topic);
  const auto key = [](const BagTopic& t) { return std::tie(t.name, t.type, t.encodingName); };
  std::sort(topics_.begin(), topics_.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  for (std::uint32_t i = 0; i < topics_.size(); ++i) numbers[key(topics_[i])] = i;
  for (const auto& part : parts_) {
    std::vector<std::uint32_t>& of = topicOf_.emplace_back();
    for (const BagTopic& topic : part->topics) of.push_back(numbers[key(topic)]);
  }
}

/// Parts of one recording follow one another.
void PartsBag::warnOfOverlaps() {
  struct Span {
    std::int64_t begin, end;
    const std::string* name;
  };
  std::vector<Span> spans;
  for (const auto& part : parts_) {
    if (part->places.empty()) continue;
    const auto [first, last] =
        std::minmax_element(part->places.begin(), part->places.end(),
                            [](const auto& a, const auto& b) { return a.time < b.time; });
    spans.push_back({first->time, last->time, &part->name()});
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.begin < b.begin; });
  for (std::size_t i = 1; i < spans.size(); ++i) {
    const double shared =
        static_cast<double>(std::min(spans[i].end, spans[i - 1].end)) - static_cast<double>(spans[i].begin);
    if (shared <= 0 || 2 * shared < static_cast<double>(spans[i].end) - static_cast<double>(spans[i].begin))
      continue;
    warnings_.push_back(
        fmt::format("{} and {} were recorded at the same time; if they are not parts of one bag, give "
                    "one of them",
                    *spans[i - 1].name, *spans[i].name));
    return;
  }
}

void PartsBag::mergeMessages() {
  std::vector<BagPlace> places;
  std::uint64_t blocks = 0;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    BagPart& part = *parts_[p];
    firstBlock_.push_back(static_cast<std::uint32_t>(blocks));
    for (BagPlace& place : part.places) {
      place.block += firstBlock_.back();
      place.topic = topicOf_[p][place.topic];
    }
    if (places.empty())
      places.swap(part.places);
    else
      places.insert(places.end(), part.places.begin(), part.places.end());
    std::vector<BagPlace>().swap(part.places);
    blocks += part.blocks();
    if (blocks > std::numeric_limits<std::uint32_t>::max())
      fail(ErrorCode::tooLarge, "a bag of {} chunks; give fewer of its files", blocks);
    warnings_.insert(warnings_.end(), part.warnings.begin(), part.warnings.end());
  }
  std::sort(places.begin(), places.end(), [](const BagPlace& a, const BagPlace& b) {
    return std::tie(a.time, a.block, a.offset) < std::tie(b.time, b.block, b.offset);
  });
  messages_.reserve(places.size());
  blocks_.reserve(places.size());
  offsets_.reserve(places.size());
  for (const BagPlace& place : places) {
    messages_.push_back({place.topic, place.time});
    blocks_.push_back(place.block);
    offsets_.push_back(place.offset);
    ++topics_[place.topic].messages;
  }
}

}  // namespace

bool isBag(const fs::path& path) {
  std::error_code none;
  if (fs::is_directory(path, none)) return isBagFolder(path);
  try {
    const FileBytes file(path);
    const auto format = bagFormat(file);
    // Others use SQLite and Zstandard, too.
    const bool named = !bagExtension(path).empty();
    return format && (named || format == BagFormat::ros1 || format == BagFormat::mcap);
  } catch (const Error&) {
    return false;
  }
}

std::unique_ptr<Bag> openBag(const fs::path& path) {
  BagFiles bag;
  std::error_code none;
  if (fs::is_directory(path, none))
    bag = bagFilesIn(path);
  else
    bag.files.push_back(path);
  std::vector<std::unique_ptr<BagPart>> parts;
  for (const fs::path& file : bag.files) {
    try {
      parts.push_back(openPart(file));
    } catch (const Error& error) {
      // One of several files is not the bag.
      if (bag.files.size() == 1) throw;
      bag.warnings.emplace_back(error.what());
      if (&file == &bag.files.back() && parts.empty()) throw;
    }
  }
  return std::make_unique<PartsBag>(std::move(parts), std::move(bag.warnings));
}

}  // namespace estancia::ros
