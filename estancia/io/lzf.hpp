// LZF: decompression of PCD files (format of Marc Lehmann's LibLZF).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace estancia::io {

/// Largest compression factor of LZF: three bytes stand for at most 264.
constexpr std::size_t kMaxLzfGain = 88;

/// Decompresses `packed` to `size` bytes. Throws Error when it is damaged or of another size.
std::string unpackLzf(std::string_view packed, std::size_t size);

}  // namespace estancia::io
