// Available memory: bytes that this process may still allocate.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace estancia {

/// Bytes that this process may still allocate without swapping: what the system has available, at most what
/// the limits of its cgroups (v1 and v2) and of its address space leave. The largest number if unknown.
/// `root` is where /proc and /sys are, for tests.
std::uint64_t availableMemory(const std::filesystem::path& root = "/");

}  // namespace estancia
