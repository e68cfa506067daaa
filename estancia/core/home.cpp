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

std::filesystem::path userHome() {
  if (std::string home = environment("HOME"); !home.empty()) return home;
  const passwd* entry = getpwuid(geteuid());
  return entry == nullptr ? "" : entry->pw_dir;
}

}  // namespace estancia
