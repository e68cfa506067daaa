// SHA-256 of bytes and files, as 64 hex digits; SHA-1 of files, as 40.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace estancia {

std::string sha256(std::string_view bytes);

/// Throws Error when the file cannot be read.
std::string sha256OfFile(const std::filesystem::path& path);

/// SHA-1, which old publishers give: it tells damage, not forgery. Throws Error as above.
std::string sha1OfFile(const std::filesystem::path& path);

}  // namespace estancia
