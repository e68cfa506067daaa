// Binary serialization: numbers and texts to little-endian bytes and back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia {

static_assert(std::endian::native == std::endian::little, "binary files are little-endian");

class ByteWriter {
 public:
  template <class Value>
  void number(Value value) {
    static_assert(std::is_arithmetic_v<Value>);
    raw({reinterpret_cast<const char*>(&value), sizeof value});
  }
  /// A count, then the numbers.
  template <class Value>
  void numbers(const std::vector<Value>& values) {
    static_assert(std::is_arithmetic_v<Value>);
    number(static_cast<std::uint64_t>(values.size()));
    raw({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)});
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  void raw(std::string_view bytes) { bytes_ += bytes; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads values in order; never beyond the end, and never allocates more than the bytes hold.
class ByteReader {
 public:
  /// `name` and `remedy` stand in the message of every Error: "NAME: it is truncated; REMEDY".
  ByteReader(std::string_view bytes, std::string name, std::string remedy);

  template <class Value>
  Value number() {
    static_assert(std::is_arithmetic_v<Value>);
    Value value{};
    std::memcpy(&value, raw(sizeof value).data(), sizeof value);
    return value;
  }
  template <class Value>
  std::vector<Value> numbers() {
    static_assert(std::is_arithmetic_v<Value>);
    std::vector<Value> values(count(sizeof(Value)));
    const std::string_view bytes = raw(values.size() * sizeof(Value));
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  /// The number of items that follow, of at least `bytes` each.
  std::size_t count(std::size_t bytes);
  std::string text() { return std::string(raw(number<std::uint32_t>())); }
  std::string_view raw(std::size_t bytes);
  std::size_t remaining() const { return rest_.size(); }
  [[noreturn]] void fail(std::string_view why, ErrorCode code = ErrorCode::malformedFile) const;

 private:
  std::string_view rest_;
  std::string name_, remedy_;
};

}  // namespace estancia
