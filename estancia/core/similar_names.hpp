// Similar names: names that differ only in case or in blanks, and so were meant as one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// Without blanks at its ends.
std::string_view trimmed(std::string_view name);

/// Whether the two differ, but only in the case of ASCII letters or in blanks at their ends.
bool isSimilar(std::string_view one, std::string_view other);

/// Groups of at least two names that are similar, in their order.
std::vector<std::vector<std::string>> similarNames(const std::set<std::string>& names);

/// A sentence for each group of rooms, which are taken for different ones.
std::vector<std::string> warningsOfSimilarRooms(const std::set<std::string>& rooms);

}  // namespace estancia
