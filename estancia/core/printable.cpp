#include "estancia/core/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "estancia/core/vocabulary.hpp"

namespace estancia {
namespace {

/// Bytes of the valid UTF-8 character that `text` starts with (RFC 3629), 0 when it is broken or to be
/// shown as bytes.
std::size_t utf8Length(std::string_view text) {
  const auto byte = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7F ? 0 : 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  const bool overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
  const bool surrogate = first == 0xED && byte(1) >= 0xA0;
  const bool c1 = first == 0xC2 && byte(1) < 0xA0;
  const bool separatorOrBidi = first == 0xE2 && ((byte(1) == 0x80 && byte(2) >= 0xA8 && byte(2) <= 0xAE) ||
                                                 (byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9));
  if (c1 || separatorOrBidi) return 0;
  return overlong || surrogate || (first == 0xF4 && byte(1) >= 0x90) ? 0 : length;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8Length(text.substr(i));
    if (length == 0)
      result += fmt::format("\\x{:02X}", static_cast<unsigned char>(text[i]));
    else
      result += text.substr(i, length);
    i += std::max<std::size_t>(length, 1);
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
