// CDR writer: puts the fields of a message of ROS 2 one behind the other (OMG XCDR1, little-endian).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace estancia::ros {

/// A number lies at a multiple of its size, counted from behind the header of four bytes.
class CdrWriter {
 public:
  CdrWriter();

  template <class Number>
  requires std::integral<Number> || std::floating_point<Number>
  void put(Number number) {
    static_assert(sizeof(Number) <= 8);
    align(sizeof(Number));
    append(&number, sizeof(Number));
  }

  template <class Enumeration>
  requires std::is_enum_v<Enumeration>
  void put(Enumeration value) { put(static_cast<std::underlying_type_t<Enumeration>>(value)); }

  /// Throws Error (tooLarge) beyond 4 GB.
  void put(std::string_view text);
  /// Writes the length of a sequence; its elements are put next. Throws Error (tooLarge) beyond 2³² − 1.
  void putCount(std::size_t count);
  /// uint8[]. Throws Error (tooLarge) beyond 4 GB.
  void putBytes(std::span<const std::byte> bytes);
  /// builtin_interfaces/Time or Duration [ns]; beyond what it can hold (the year 2038), the nearest.
  void putTime(std::int64_t nanoseconds);

  /// The message with its header; the writer begins anew.
  std::vector<std::byte> take();

 private:
  void align(std::size_t size);
  void append(const void* data, std::size_t size);

  std::vector<std::byte> bytes_;
};

}  // namespace estancia::ros
