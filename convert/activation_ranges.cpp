// SPDX-License-Identifier: Apache-2.0
#include "convert/activation_ranges.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "estancia/core/error.hpp"

namespace estancia::convert {
namespace {

/// The number in front of a blank, which is taken off `line`; nothing when there is none.
std::optional<float> takeNumber(std::string_view& line) {
  float value = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
  const auto length = static_cast<std::size_t>(end - line.data());
  if (error != std::errc() || !std::isfinite(value) || length == line.size() || line[length] != ' ')
    return std::nullopt;
  line.remove_prefix(length + 1);
  return value;
}

}  // namespace

ActivationRanges readRanges(const std::filesystem::path& file) {
  std::ifstream lines(file);
  if (!lines)
    throw Error(ErrorCode::fileNotFound, fmt::format("{} cannot be read; check the name", file.string()));
  ActivationRanges ranges;
  std::size_t number = 0;
  for (std::string text; std::getline(lines, text);) {
    ++number;
    if (text.empty() || text[0] == '#') continue;
    const auto wrong = [&](const char* what) {
      return Error(ErrorCode::malformedFile, fmt::format("{}:{}: {}", file.string(), number, what));
    };
    std::string_view line = text;
    const auto low = takeNumber(line), high = takeNumber(line);
    if (!low || !high || line.empty()) throw wrong("no line `LOW HIGH NAME`; make the file again");
    if (*low > 0 || *high < 0) throw wrong("the range must hold 0; make the file again");
    if (!ranges.try_emplace(std::string(line), ActivationRange{*low, *high}).second)
      throw wrong("the value is named twice; make the file again");
  }
  return ranges;
}

std::string rangesText(const ActivationRanges& ranges, const std::string& comment) {
  std::string text = "# " + comment + '\n';
  for (const auto& [name, range] : ranges) text += fmt::format("{} {} {}\n", range.low, range.high, name);
  return text;
}

}  // namespace estancia::convert
