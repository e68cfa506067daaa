// Scalar: a number in a binary file, by type, size and byte order.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace estancia::io {

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
double numberAt(const Scalar& scalar, const char* bytes, bool swapped = false);

}  // namespace estancia::io
