// Wire format: the fields of serialized ROS messages, read from ROS 1's encoding or CDR and written in CDR.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace estancia::ros {

/// Serialization of ROS messages.
enum class Encoding {
  /// Little-endian and packed; strings have no terminating zero.
  ros1,
  /// OMG's Common Data Representation (XCDR1): a header of four bytes, then aligned from there.
  cdr
};

/// Reads one field after the other. Never reads beyond the end, and never allocates more than the message
/// holds. Every function throws Error (truncatedFile) where the message ends too early.
class WireReader {
 public:
  /// The bytes must outlive it. Throws Error: truncatedFile; unsupportedFile for a CDR header of another
  /// kind than plain CDR (XCDR1 or 2, either byte order).
  WireReader(std::span<const std::byte> message, Encoding encoding);

  template <class Value>
  Value number() {
    static_assert(std::is_arithmetic_v<Value>);
    align(sizeof(Value));
    Value value{};
    copy(take(sizeof(Value)), &value, 1);
    return value;
  }
  bool boolean() { return number<std::uint8_t>() != 0; }
  std::string text();
  /// A field of a fixed count.
  template <class Value, std::size_t Count>
  std::array<Value, Count> array() {
    std::array<Value, Count> values{};
    read(std::span<Value>(values));
    return values;
  }
  /// A count, then the numbers.
  template <class Value>
  std::vector<Value> numbers() {
    std::vector<Value> values(count(sizeof(Value)));
    read(std::span<Value>(values));
    return values;
  }
  /// The number of items that follow, of at least `bytes` each.
  std::size_t count(std::size_t bytes);
  /// A count, then as many bytes, which are not copied.
  std::span<const std::byte> bytes() { return take(count(1)); }
  /// A time [ns].
  std::int64_t time();
  Encoding encoding() const { return encoding_; }

 private:
  template <class Value>
  void read(std::span<Value> values) {
    if (values.empty()) return;
    align(sizeof(Value));
    copy(take(values.size() * sizeof(Value)), values.data(), values.size());
  }
  std::span<const std::byte> take(std::size_t size);
  void align(std::size_t size);
  template <class Value>
  void copy(std::span<const std::byte> from, Value* to, std::size_t values) const {
    std::memcpy(to, from.data(), from.size());
    if (!swaps_ || sizeof(Value) == 1) return;
    for (std::size_t i = 0; i < values; ++i) {
      std::byte* const first = reinterpret_cast<std::byte*>(to + i);
      for (std::size_t a = 0, b = sizeof(Value) - 1; a < b; ++a, --b) std::swap(first[a], first[b]);
    }
  }

  std::span<const std::byte> message_;
  std::size_t at_ = 0;      // in message_
  std::size_t origin_ = 0;  // what alignment is counted from
  std::size_t maxAlignment_ = 1;
  bool swaps_ = false;
  Encoding encoding_;
};

/// Puts one field behind the other (OMG XCDR1, little-endian). A number lies at a multiple of its size,
/// counted from behind the header of four bytes.
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
