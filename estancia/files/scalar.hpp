// Scalar: a number in a binary file, by type, size and byte order.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace estancia::io {

static_assert(std::endian::native == std::endian::little, "numbers are copied as little-endian");

/// A number type: I (signed) or U (unsigned) of 1, 2, 4 or 8 bytes, F (IEEE 754) of 4 or 8.
struct Scalar {
  char type = 'F';
  std::size_t size = 4;

  bool exists() const {
    const bool whole = (type == 'I' || type == 'U') && (size == 1 || size == 2);
    return whole || ((type == 'I' || type == 'U' || type == 'F') && (size == 4 || size == 8));
  }
};

/// The number at `bytes`, little-endian, or big-endian when `swapped`. Requires exists().
inline double numberAt(const Scalar& scalar, const char* bytes, bool swapped = false) {
  const auto as = [&bytes]<class Value>(Value value) {
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
  };
  std::array<char, 8> turned;
  if (swapped) {
    std::reverse_copy(bytes, bytes + scalar.size, turned.begin());
    bytes = turned.data();
  }
  if (scalar.type == 'F') return scalar.size == 4 ? as(float()) : as(double());
  const bool isSigned = scalar.type == 'I';
  switch (scalar.size) {
    case 1:
      return isSigned ? as(std::int8_t()) : as(std::uint8_t());
    case 2:
      return isSigned ? as(std::int16_t()) : as(std::uint16_t());
    case 4:
      return isSigned ? as(std::int32_t()) : as(std::uint32_t());
    default:
      return isSigned ? as(std::int64_t()) : as(std::uint64_t());
  }
}

}  // namespace estancia::io
