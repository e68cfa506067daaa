#include "estancia/io/lzf.hpp"

#include "estancia/core/error.hpp"

namespace estancia::io {

std::string unpackLzf(std::string_view packed, std::size_t size) {
  const auto damaged = [] { return Error(ErrorCode::corruptFile, "damaged compressed data"); };
  if (size / kMaxLzfGain > packed.size()) throw damaged();
  std::string bytes;
  bytes.reserve(size);
  std::size_t i = 0;
  const auto next = [&] {
    if (i == packed.size()) throw damaged();
    return static_cast<unsigned char>(packed[i++]);
  };
  while (i < packed.size()) {
    constexpr std::size_t literal = 32;  // below: that many bytes and one, as they are
    const std::size_t control = next();
    if (control < literal) {
      const std::size_t count = control + 1;
      if (count > packed.size() - i || count > size - bytes.size()) throw damaged();
      bytes += packed.substr(i, count);
      i += count;
      continue;
    }
    std::size_t count = control >> 5U;  // a match: how long …
    if (count == 7) count += next();
    count += 2;
    const std::size_t back = ((control & 31U) << 8U) + next() + 1;  // … and how far behind
    if (back > bytes.size() || count > size - bytes.size()) throw damaged();
    for (std::size_t k = 0; k < count; ++k) bytes += bytes[bytes.size() - back];  // it may overlap itself
  }
  if (bytes.size() != size) throw damaged();
  return bytes;
}

}  // namespace estancia::io
