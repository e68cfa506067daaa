// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/dds_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "estancia/core/ascii.hpp"
#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

constexpr std::string_view topicPrefix = "rt";
/// DDS keeps names of 255 bytes.
constexpr std::size_t longestDdsName = 255;

/// A letter or underscore, then letters, digits and underscores; in no locale.
bool isDdsWord(std::string_view text) {
  const auto letter = [](char c) { return isLetter(c) || c == '_'; };
  return !text.empty() && letter(text.front()) &&
         std::ranges::all_of(text, [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

std::vector<std::string_view> partsBetween(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0;;) {
    const std::size_t next = text.find(separator, at);
    parts.push_back(text.substr(at, next - at));
    if (next == std::string_view::npos) return parts;
    at = next + separator.size();
  }
}

/// "/camera/image_raw"
bool isRosTopic(std::string_view topic) {
  return topic.size() > 1 && topic.front() == '/' && topic.size() + topicPrefix.size() <= longestDdsName &&
         std::ranges::all_of(partsBetween(topic.substr(1), "/"), isDdsWord);
}

bool isRosFolder(std::string_view folder) {
  return folder == "msg" || folder == "srv" || folder == "action";
}

}  // namespace

std::string ddsTopicName(const std::string& topic) {
  if (!isRosTopic(topic))
    fail(ErrorCode::invalidInput,
         "\"{:.80}\" is no topic; name one like /camera/image_raw: letters, digits and underscores between "
         "slashes",
         topic);
  return std::string(topicPrefix) + topic;
}

std::string ddsTypeName(const std::string& type) {
  const auto parts = partsBetween(type, "/");
  const std::string_view folder = parts.size() == 3 ? parts[1] : "msg";
  if (parts.size() < 2 || parts.size() > 3 || !isDdsWord(parts.front()) || !isDdsWord(parts.back()) ||
      !isRosFolder(folder) || type.size() > longestDdsName - 20)
    fail(ErrorCode::invalidInput, "\"{:.80}\" is no type of a message; name one like sensor_msgs/Image",
         type);
  return fmt::format("{}::{}::dds_::{}_", parts.front(), folder, parts.back());
}

std::string rosTopicName(const std::string& ddsTopic) {
  if (!ddsTopic.starts_with(topicPrefix)) return "";
  std::string topic = ddsTopic.substr(topicPrefix.size());
  return isRosTopic(topic) ? topic : "";
}

std::string rosTypeName(const std::string& ddsType) {
  const auto parts = partsBetween(ddsType, "::");
  if (parts.size() != 4 || parts[2] != "dds_" || !isDdsWord(parts[0]) || !isRosFolder(parts[1]) ||
      parts[3].size() < 2 || !parts[3].ends_with('_') || !isDdsWord(parts[3]))
    return "";
  const std::string_view name = parts[3].substr(0, parts[3].size() - 1);
  return parts[1] == "msg" ? fmt::format("{}/{}", parts[0], name)
                           : fmt::format("{}/{}/{}", parts[0], parts[1], name);
}

}  // namespace estancia::ros
