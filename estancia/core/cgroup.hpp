// The control groups whose limits this process has to keep.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace estancia {

/// The folders of the control groups around this process, of version 2 and of version 1's `controller`
/// ("cpu", "memory"): its own first, then those around it. `root` is where /proc and /sys are looked for, for
/// tests.
std::vector<std::filesystem::path> cgroupFolders(const std::filesystem::path& root,
                                                 std::string_view controller);

}  // namespace estancia
