// Where a user's own files are.
#pragma once

#include <filesystem>
#include <string>

namespace estancia {

/// "" when the variable is not set.
std::string environment(const std::string& variable);

/// $HOME, else what the system's list of users says, as the shell's ~ does: services have no HOME.
std::filesystem::path userHome();

}  // namespace estancia
