// Archive member: one file out of a zip, or a tar plain or compressed by gzip, bzip2, xz or zstd.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace estancia {

/// Writes the member `name` of `archive` to `target`, whole or not at all. `name` is the member's path, or
/// only its last part; nothing else of the archive is looked at, so that none of its paths can do harm.
/// Returns false when there is no such file in it. Throws Error when the archive is damaged or no archive,
/// when the member is longer than `maxBytes`, and when `target` cannot be written.
bool extractMember(const std::filesystem::path& archive, const std::string& name,
                   const std::filesystem::path& target, std::uint64_t maxBytes);

}  // namespace estancia
