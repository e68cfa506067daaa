// Protobuf wire format: the fields of a serialized message, one after the other (protobuf.dev, "Encoding").
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace estancia::protobuf {

/// Thrown when bytes are no message.
struct Malformed {};

struct Field {
  std::uint32_t number = 0;
  /// Of a varint field.
  std::optional<std::uint64_t> value = {};
  /// Of a length-delimited field: a text, bytes, or a message.
  std::optional<std::string_view> bytes = {};
  /// The whole field with its tag.
  std::string_view whole = {};
};

/// Walks over a message. Views point into it.
class FieldReader {
 public:
  explicit FieldReader(std::string_view message) : rest_(message) {}
  /// The next field, or nothing at the end. Throws Malformed.
  std::optional<Field> next();

 private:
  std::uint64_t varint();
  std::string_view take(std::uint64_t size);

  std::string_view rest_;
};

/// Calls use(bytes) for each length-delimited field of this number.
void forEachField(std::string_view message, std::uint32_t number,
                  const std::function<void(std::string_view)>& use);

/// The message with change(bytes) in the place of each length-delimited field of this number.
std::string withChanged(std::string_view message, std::uint32_t number,
                        const std::function<std::string(std::string_view)>& change);

/// A field as bytes.
std::string varintField(std::uint32_t number, std::uint64_t value);
std::string bytesField(std::uint32_t number, std::string_view bytes);

}  // namespace estancia::protobuf
