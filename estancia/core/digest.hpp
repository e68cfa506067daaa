// SHA-256 of bytes and files, as 64 hex digits.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace estancia {

std::string sha256(std::string_view bytes);

/// Throws Error when the file cannot be read.
std::string sha256OfFile(const std::filesystem::path& path);

}  // namespace estancia
