// Control groups (cgroups): folders of those that limit this process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace estancia {

/// Folders of the control groups of this process, of version 2 and of version 1's `controller` ("cpu",
/// "memory"): its own first, then the enclosing ones. `root` is where /proc and /sys are, for tests.
std::vector<std::filesystem::path> cgroupFolders(const std::filesystem::path& root,
                                                 std::string_view controller);

}  // namespace estancia
