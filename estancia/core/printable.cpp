// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/printable.hpp"

#include <fmt/format.h>

#include "estancia/core/utf8.hpp"

namespace estancia {
namespace {

/// Control characters (C0, DEL, C1), line separators, and controls of the writing direction.
bool isControl(char32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || (code >= 0x2028 && code <= 0x202E) ||
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::string_view before = text;
    const auto code = takeCodePoint(text);
    const std::string_view taken = before.substr(0, before.size() - text.size());
    if (code && !isControl(*code))
      result += taken;
    else
      for (const char byte : taken) result += fmt::format("\\x{:02X}", static_cast<unsigned char>(byte));
  }
  return result;
}

}  // namespace estancia
