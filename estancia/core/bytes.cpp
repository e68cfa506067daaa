// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/bytes.hpp"

#include <fmt/format.h>

#include <utility>

namespace estancia {

ByteReader::ByteReader(std::string_view bytes, std::string name, std::string remedy)
    : rest_(bytes), name_(std::move(name)), remedy_(std::move(remedy)) {}

std::size_t ByteReader::count(std::size_t bytes) {
  const auto found = number<std::uint64_t>();
  if (found > remaining() / bytes) fail("it is truncated", ErrorCode::truncatedFile);
  return found;
}

std::string_view ByteReader::raw(std::size_t bytes) {
  if (bytes > rest_.size()) fail("it is truncated", ErrorCode::truncatedFile);
  const std::string_view taken = rest_.substr(0, bytes);
  rest_.remove_prefix(bytes);
  return taken;
}

void ByteReader::fail(std::string_view why, ErrorCode code) const {
  throw Error(code, fmt::format("{}: {}; {}", name_, why, remedy_));
}

}  // namespace estancia
