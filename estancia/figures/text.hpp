// Text that came from outside (labels, rooms, file names) made fit for a page: valid, short, measured.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace estancia::report {

/// The text as valid UTF-8 on one line: other bytes become U+FFFD, control characters and line breaks spaces.
std::string cleanText(std::string_view text);

/// At most `length` code points of the cleaned text; a cut is marked by "…".
std::string shorten(std::string_view text, std::size_t length);

/// "cup, mug" → "cup"; the whole line where it has no comma.
std::string firstSynonym(std::string_view label);

/// Estimated width in a proportional sans-serif of size 1 (Helvetica's advance widths; wide scripts count 1).
double textWidth(std::string_view text);

/// The text, shortened to `width` in size 1 as textWidth() estimates it; one code point stays.
std::string shortenToWidth(std::string_view text, double width);

/// A number without trailing zeros, with a point whatever the locale: 1.50 → "1.5", -0.001 → "0".
std::string number(double value, int decimals = 2);

/// Three significant digits for people: 0.0123, 1.23, 123; "n/a" when not finite.
std::string significant(double value);

/// 1234567 → "1,234,567"
std::string grouped(std::size_t count);

/// "1 frame", "2 frames"
std::string counted(std::size_t count, const std::string& noun);

}  // namespace estancia::report
