// Files that are there whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace estancia {

/// Writes `bytes` to a file beside `path`, then renames it to `path`, replacing what was there. Throws Error
/// when that fails (no such folder, read-only, disk full); then `path` is as it was and nothing is left
/// beside it.
void writeWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace estancia
