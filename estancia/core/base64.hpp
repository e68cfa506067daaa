// Base64: bytes ↔ text (RFC 4648).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace estancia {

std::string toBase64(std::string_view bytes);

/// The bytes of a padded text, whose length is a multiple of 4; nothing when it is no base64. Each `=` gives
/// a zero byte at the end.
std::optional<std::string> fromBase64(std::string_view text);

}  // namespace estancia
