// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/home.hpp"

#include <pwd.h>
#include <unistd.h>

#include <cstdlib>

namespace estancia {

std::string environment(const std::string& variable) {
  const char* value = std::getenv(variable.c_str());
  return value == nullptr ? "" : value;
}

std::filesystem::path cacheFolder(const std::filesystem::path& within) {
  if (std::string own = environment("ESTANCIA_CACHE"); !own.empty()) return own;
  const std::string shared = environment("XDG_CACHE_HOME");
  const std::filesystem::path folder = shared.empty() ? userHome() / ".cache" : std::filesystem::path(shared);
  return within.empty() ? folder / "estancia" : folder / "estancia" / within;
}

std::filesystem::path userHome() {
  if (std::string home = environment("HOME"); !home.empty()) return home;
  const passwd* entry = getpwuid(geteuid());
  return entry == nullptr ? "" : entry->pw_dir;
}

}  // namespace estancia
