// Bag part: one file of a bag, its topics and where its messages are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "estancia/ros/bag.hpp"
#include "estancia/ros/bag_blocks.hpp"

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

  std::string name_;

 private:
  std::unordered_map<std::string, std::uint32_t> topicNumbers_;
};

/// Throw Error when not even their beginning can be used.
std::unique_ptr<BagPart> openRos1Part(FileBytes file);
std::unique_ptr<BagPart> openMcapPart(FileBytes file);
std::unique_ptr<BagPart> openSqlitePart(FileBytes file);

/// "pkg/msg/Type" → "pkg/Type".
std::string typeName(std::string_view type);

}  // namespace estancia::ros
