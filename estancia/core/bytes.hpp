// Numbers and texts to bytes and back: what our binary files are made of. Little-endian.
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

/// Takes values off the front; never beyond the end, and never more memory than the file is long.
class ByteReader {
 public:
  /// `name` and `remedy` make up the message of every Error: "NAME: it is cut short; REMEDY".
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
  /// How many items follow that take at least `bytes` each.
  std::size_t count(std::size_t bytes);
  std::string text() { return std::string(raw(number<std::uint32_t>())); }
  std::string_view raw(std::size_t bytes);
  std::size_t left() const { return rest_.size(); }
  [[noreturn]] void fail(std::string_view why) const;

 private:
  std::string_view rest_;
  std::string name_, remedy_;
};

}  // namespace estancia
