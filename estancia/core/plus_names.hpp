// Combined names: splits "inception-v3+gist" at its plus signs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace estancia {

/// The names between the plus signs, empty ones included; at least one. An existing path is one name.
inline std::vector<std::string> splitAtPlus(const std::string& names) {
  std::error_code ignored;
  if (std::filesystem::exists(names, ignored)) return {names};
  std::vector<std::string> split;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = names.find('+', begin);
    split.push_back(names.substr(begin, end - begin));
  }
  return split;
}

}  // namespace estancia
