// UTF-8: the code points of a text, one after the other (RFC 3629).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace estancia {

/// Takes one code point off the front of a text that is not empty; nothing, and one byte, where there is no
/// valid one.
std::optional<char32_t> takeCodePoint(std::string_view& text);

}  // namespace estancia
