// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/cgroup.hpp"

#include <fstream>
#include <string>

namespace estancia {
namespace fs = std::filesystem;

std::vector<fs::path> cgroupFolders(const fs::path& root, std::string_view controller) {
  std::vector<fs::path> folders;
  const fs::path mount = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");  // lines ID:CONTROLLERS:PATH
  for (std::string line; std::getline(groups, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool version2 = controllers == ",,";
    if (!version2 && controllers.find("," + std::string(controller) + ",") == std::string::npos) continue;
    const fs::path top = version2 ? mount : mount / controller;
    fs::path at = top / fs::path(line.substr(second + 1)).relative_path();
    for (;; at = at.parent_path()) {
      folders.push_back(at);
      if (at == top || !at.has_relative_path()) break;
    }
  }
  return folders;
}

}  // namespace estancia
