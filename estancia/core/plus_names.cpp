// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/plus_names.hpp"

#include <cstddef>
#include <filesystem>

namespace estancia {

std::vector<std::string> splitAtPlus(const std::string& names) {
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
