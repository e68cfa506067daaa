// Kept numbers: groups that are found anew get the numbers of the earlier ones that they are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace estancia {

/// How many members a new group shares with an earlier one.
using GroupOverlap = std::map<std::pair<std::size_t, std::size_t>, std::size_t>;

/// The number of each of `groups` new groups, 0 … groups − 1 without gaps: those of the earlier groups that
/// they overlap most, largest overlaps first, each once (greedy assignment). Earlier numbers beyond the last
/// one are lost. Groups without an earlier one get the free numbers, in order.
std::vector<std::size_t> keptNumbers(std::size_t groups, const GroupOverlap& overlap);

}  // namespace estancia
