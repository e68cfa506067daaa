// Combined names: splits "inception-v3+gist" at its plus signs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace estancia {

/// The names between the plus signs, empty ones included; at least one. An existing path is one name, with or
/// without plus signs.
std::vector<std::string> splitAtPlus(const std::string& names);

}  // namespace estancia
