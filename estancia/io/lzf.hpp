// LZF, the compression inside PCD files (Marc Lehmann's LibLZF).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace estancia::io {

/// No LZF stream becomes longer than so many times its size: three bytes say 264 at most.
constexpr std::size_t kMostLzfGain = 88;

/// The `size` bytes that `packed` stands for. Throws Error when it is damaged or stands for another number of
/// bytes.
std::string unpackLzf(std::string_view packed, std::size_t size);

}  // namespace estancia::io
