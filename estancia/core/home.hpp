// Home folder: where it is, and environment variables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace estancia {

/// "" when the variable is not set.
std::string environment(const std::string& variable);

/// For files that can be made again: $ESTANCIA_CACHE, or estancia/`within` in $XDG_CACHE_HOME or ~/.cache.
std::filesystem::path cacheFolder(const std::filesystem::path& within = {});

/// $HOME, else the home folder in the system's list of users, as the shell's ~ does: services have no HOME.
std::filesystem::path userHome();

}  // namespace estancia
