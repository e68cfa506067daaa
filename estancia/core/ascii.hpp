// ASCII: letters and digits as files and protocols define them, whatever the user's language (LC_CTYPE).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

constexpr bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

constexpr bool isLetterOrDigit(char c) {
  return isLetter(c) || (c >= '0' && c <= '9');
}

constexpr char lowerCase(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

constexpr char upperCase(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

/// Bytes that are no ASCII letters stay.
inline std::string lowerCase(std::string text) {
  for (char& c : text) c = lowerCase(c);
  return text;
}

}  // namespace estancia
