// Printable text: names and labels of others without control characters, for terminals and messages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace estancia {

/// The text with every byte as \xNN that belongs to a control character (C0, DEL, C1), to a line separator,
/// to a control of the writing direction (U+202A to U+202E, U+2066 to U+2069), or to no valid UTF-8 (RFC
/// 3629); everything else as it is. A second call changes nothing.
std::string printable(std::string_view text);

}  // namespace estancia
