// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/text.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "estancia/core/utf8.hpp"

namespace estancia::report {
namespace {

bool isControl(char32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x2028 || code == 0x2029;
}

// Advance widths of Helvetica for U+0020 … U+007E in 1/1000 em.
constexpr std::array<int, 95> advances{
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584};

}  // namespace

std::string cleanText(std::string_view text) {
  std::string clean;
  clean.reserve(text.size());
  while (!text.empty()) {
    const std::string_view before = text;
    const auto code = takeCodePoint(text);
    if (!code)
      clean += "\uFFFD";
    else if (isControl(*code))
      clean += ' ';
    else
      clean += before.substr(0, before.size() - text.size());
  }
  return clean;
}

std::string shorten(std::string_view text, std::size_t length) {
  const std::string clean = cleanText(text);
  std::string_view rest = clean;
  std::size_t beforeLast = 0;  // bytes of the first length - 1 code points
  for (std::size_t i = 0; i < length && !rest.empty(); ++i) {
    beforeLast = clean.size() - rest.size();
    takeCodePoint(rest);
  }
  return rest.empty() ? clean : clean.substr(0, beforeLast) + "…";
}

std::string firstSynonym(std::string_view label) {
  const std::string_view first = label.substr(0, label.find(','));
  const auto blank = first.find_last_not_of(' ');
  return std::string(blank == std::string_view::npos ? label : first.substr(0, blank + 1));
}

double textWidth(std::string_view text) {
  double width = 0;
  while (!text.empty()) {
    const char32_t code = takeCodePoint(text).value_or(0xFFFD);
    if (code >= 0x20 && code <= 0x7E)
      width += advances[code - 0x20] / 1000.0;
    else
      width += code >= 0x1100 ? 1.0 : 0.6;  // CJK and symbols are square, Latin and Greek letters are not
  }
  return width;
}

std::string shortenToWidth(std::string_view text, double width) {
  std::string shortened = cleanText(text);
  for (std::size_t length = shortened.size(); length > 1 && textWidth(shortened) > width;)
    shortened = shorten(text, --length);
  return shortened;
}

std::string number(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string significant(double value) {
  if (!std::isfinite(value)) return "n/a";
  const double size = std::abs(value);
  return number(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.1 ? 3 : 4);
}

std::string grouped(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
  return text;
}

std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", grouped(count), noun, count == 1 ? "" : "s");
}

}  // namespace estancia::report
