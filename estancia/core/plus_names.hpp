// Names that are put together: "inception-v3+gist".
#pragma once

#include <string>
#include <vector>

namespace estancia {

/// What stands between the plus signs, also where that is nothing; at least one name. A path that exists is
/// one name, whatever it is made of.
std::vector<std::string> splitAtPlus(const std::string& names);

}  // namespace estancia
