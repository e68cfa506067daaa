// Base64: bytes ↔ text (RFC 4648).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace estancia {

std::string toBase64(std::string_view bytes);

/// The bytes of a padded text (4 n characters; each `=` gives a zero byte); nothing when it is no base64.
std::optional<std::string> fromBase64(std::string_view text);

}  // namespace estancia
