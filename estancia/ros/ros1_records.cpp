// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/ros1_records.hpp"

#include <algorithm>

namespace estancia::ros {
namespace {

// Connections have their topic and little more in it [bytes].
constexpr std::uint32_t maxHeader = 65536;
// The type in the data of a connection; its message's definition may be longer [bytes].
constexpr std::uint32_t maxTypeField = 4096;

}  // namespace

std::optional<std::string_view> Ros1Record::field(std::string_view name) const {
  for (std::string_view rest = header; rest.size() >= 4;) {
    std::uint32_t length = 0;
    std::memcpy(&length, rest.data(), sizeof length);
    rest.remove_prefix(4);
    if (length > rest.size()) return std::nullopt;
    const std::string_view entry = rest.substr(0, length);
    rest.remove_prefix(length);
    if (entry.size() > name.size() && entry.starts_with(name) && entry[name.size()] == '=')
      return entry.substr(name.size() + 1);
  }
  return std::nullopt;
}

RecordState readRos1Record(ByteSource& source, std::uint64_t at, Ros1Record& record) {
  record = {};
  const auto length = source.numberAt<std::uint32_t>(at);
  if (!length || *length > maxHeader) return RecordState::none;
  // With the length of the data behind it.
  const auto header = source.at(at + 4, std::uint64_t{*length} + 4);
  if (!header) return RecordState::none;
  record.header = header->substr(0, *length);
  std::memcpy(&record.dataBytes, header->data() + *length, sizeof record.dataBytes);
  record.data = at + 4 + *length + 4;
  record.end = record.data + record.dataBytes;
  const auto op = record.number<std::uint8_t>("op");
  if (!op) return RecordState::none;
  record.op = static_cast<Ros1Op>(*op);
  return record.end <= source.size() ? RecordState::whole : RecordState::cut;
}

std::string ros1ConnectionType(ByteSource& source, const Ros1Record& connection) {
  constexpr std::string_view type = "type=";
  for (std::uint64_t at = connection.data; at + 4 <= connection.end;) {
    const auto length = source.numberAt<std::uint32_t>(at);
    at += 4;
    if (!length || *length > connection.end - at) break;
    const auto entry = source.at(at, std::min(*length, maxTypeField));
    if (entry && entry->starts_with(type)) return std::string(entry->substr(type.size()));
    at += *length;
  }
  return "";
}

std::optional<std::int64_t> ros1Time(std::string_view bytes) {
  if (bytes.size() != 8) return std::nullopt;
  std::uint32_t seconds = 0, nanoseconds = 0;
  std::memcpy(&seconds, bytes.data(), sizeof seconds);
  std::memcpy(&nanoseconds, bytes.data() + 4, sizeof nanoseconds);
  return std::int64_t{seconds} * 1'000'000'000 + nanoseconds;
}

}  // namespace estancia::ros
