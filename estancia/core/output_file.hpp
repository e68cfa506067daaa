// Atomic file writing: a file is written whole or not at all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace estancia {

/// The file that writing to `path` makes or replaces: links are followed. Throws Error (fileUnwritable) for a
/// folder, device or pipe, which a file would replace, for links in a circle, and for too long a name.
std::filesystem::path outputTarget(const std::filesystem::path& path);

/// Where to write what will be renamed to `target`: a file beside it, named after it, this machine and this
/// process. Files that killed processes of this machine left for the same target are removed, with SQLite's
/// companions. If `target` is itself such a file, the result is another name.
std::filesystem::path partFile(const std::filesystem::path& target);

/// Returns when what was written to the file, or made in the folder, would survive a power cut. Throws Error
/// (fileUnwritable) when the disk reports a failure.
void flushToDisk(const std::filesystem::path& path);

/// Writes `bytes` to a file beside outputTarget(path), then renames it, replacing an old one: at any moment,
/// a power cut included, there is the old file or the new one. Throws Error (fileUnwritable) when that fails
/// (no such folder, read-only, disk full); then `path` is as it was, and no other file is left.
void writeWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace estancia
