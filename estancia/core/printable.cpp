// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "estancia/core/utf8.hpp"
#include "estancia/core/vocabulary.hpp"

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

std::string printableLabel(std::string label) {
  std::replace(label.begin(), label.end(), '\t', ' ');
  return printable(label);
}

Vocabulary printableLabels(const Vocabulary& vocabulary) {
  std::vector<std::string> labels;
  for (const std::string& label : vocabulary.labels()) labels.push_back(printableLabel(label));
  if (labels == vocabulary.labels()) return vocabulary;
  return Vocabulary(std::move(labels), vocabulary.layout().parts);
}

}  // namespace estancia
