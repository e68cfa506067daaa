// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/scalar.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace estancia::io {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as little-endian");

template <typename T>
double valueAt(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

}  // namespace

double numberAt(const Scalar& scalar, const char* bytes, bool swapped) {
  std::array<char, 8> turned;
  if (swapped) {
    std::reverse_copy(bytes, bytes + scalar.size, turned.begin());
    bytes = turned.data();
  }
  if (scalar.type == 'F') return scalar.size == 4 ? valueAt<float>(bytes) : valueAt<double>(bytes);
  const bool isSigned = scalar.type == 'I';
  switch (scalar.size) {
    case 1:
      return isSigned ? valueAt<std::int8_t>(bytes) : valueAt<std::uint8_t>(bytes);
    case 2:
      return isSigned ? valueAt<std::int16_t>(bytes) : valueAt<std::uint16_t>(bytes);
    case 4:
      return isSigned ? valueAt<std::int32_t>(bytes) : valueAt<std::uint32_t>(bytes);
    default:
      return isSigned ? valueAt<std::int64_t>(bytes) : valueAt<std::uint64_t>(bytes);
  }
}

}  // namespace estancia::io
