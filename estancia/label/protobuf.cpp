#include "estancia/label/protobuf.hpp"

namespace estancia::protobuf {
namespace {

enum WireType : std::uint32_t { varintType = 0, fixed64Type = 1, bytesType = 2, fixed32Type = 5 };

std::string varintBytes(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7U) bytes += static_cast<char>(value | 0x80U);
  return bytes + static_cast<char>(value);
}

}  // namespace

std::uint64_t FieldReader::varint() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const auto byte = static_cast<unsigned char>(take(1)[0]);
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte < 0x80) return value;
  }
  throw Malformed();
}

std::string_view FieldReader::take(std::uint64_t size) {
  if (size > rest_.size()) throw Malformed();
  const std::string_view taken = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return taken;
}

std::optional<Field> FieldReader::next() {
  if (rest_.empty()) return {};
  const std::string_view start = rest_;
  const std::uint64_t tag = varint();
  Field field{.number = static_cast<std::uint32_t>(tag >> 3U)};
  switch (tag & 7U) {
    case varintType:
      field.value = varint();
      break;
    case fixed64Type:
      take(8);
      break;
    case bytesType:
      field.bytes = take(varint());
      break;
    case fixed32Type:
      take(4);
      break;
    default:
      throw Malformed();
  }
  if (field.number == 0) throw Malformed();
  field.whole = start.substr(0, start.size() - rest_.size());
  return field;
}

void forEachField(std::string_view message, std::uint32_t number,
                  const std::function<void(std::string_view)>& use) {
  FieldReader reader(message);
  while (const auto field = reader.next())
    if (field->number == number && field->bytes) use(*field->bytes);
}

std::string withChanged(std::string_view message, std::uint32_t number,
                        const std::function<std::string(std::string_view)>& change) {
  std::string changed;
  changed.reserve(message.size() + 64);
  FieldReader reader(message);
  while (const auto field = reader.next())
    if (field->number == number && field->bytes)
      changed += bytesField(number, change(*field->bytes));
    else
      changed += field->whole;
  return changed;
}

std::string varintField(std::uint32_t number, std::uint64_t value) {
  return varintBytes(number << 3U | varintType) + varintBytes(value);
}

std::string bytesField(std::uint32_t number, std::string_view bytes) {
  std::string field = varintBytes(number << 3U | bytesType) + varintBytes(bytes.size());
  return field.append(bytes);
}

}  // namespace estancia::protobuf
