// Files that are there whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace estancia {

/// The file that writing to `path` makes or replaces: links are followed. Throws Error when something else
/// stands there (a folder, a device, a pipe), as a file would take its place, and when links lead in a
/// circle.
std::filesystem::path outputTarget(const std::filesystem::path& path);

/// Writes `bytes` to a file beside outputTarget(path), then renames it, replacing what was there. Throws
/// Error when that fails (no such folder, read-only, disk full); then `path` is as it was and nothing is left
/// beside it.
void writeWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace estancia
