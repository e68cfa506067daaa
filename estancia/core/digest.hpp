// Digests: SHA-256 of bytes and files, SHA-1 of files, as hex digits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace estancia {

std::string sha256(std::string_view bytes);
/// The digest itself, 32 bytes.
std::string sha256Bytes(std::string_view bytes);

/// Throws Error (fileUnreadable).
std::string sha256OfFile(const std::filesystem::path& path);

}  // namespace estancia
