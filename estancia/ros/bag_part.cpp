// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/bag_part.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::ros {
namespace {

// Three days at a thousand messages a second; more takes more memory than it is worth.
constexpr std::size_t maxMessages = 250'000'000;

}  // namespace

std::string typeName(std::string_view type) {
  constexpr std::string_view messageFolder = "/msg/";
  std::string name = printable(type);
  if (const auto at = name.find(messageFolder); at != std::string::npos)
    name.replace(at, messageFolder.size(), "/");
  return name;
}

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

}  // namespace estancia::ros
