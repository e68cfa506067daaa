// Atomic file writing: a file is written whole or not at all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace estancia {

/// The file that writing to `path` makes or replaces: links are followed. Throws Error (fileUnwritable) when
/// it is a folder, a device or a pipe, which a file would replace, and when links form a circle.
std::filesystem::path outputTarget(const std::filesystem::path& path);

/// Writes `bytes` to a file beside outputTarget(path), then renames it, replacing an old one. Throws Error
/// (fileUnwritable) when that fails (no such folder, read-only, disk full); then `path` is as it was and no
/// other file is left.
void writeWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace estancia
