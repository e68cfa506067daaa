// Which names are likely wrong, by what a classifier says of samples that it did not learn from.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// Confident learning (Northcutt, Jiang, Chuang, JAIR 70, 2021, section 3): a sample counts for the likeliest
/// of the words that it is at least as sure of as samples of that name are on average; how many samples of
/// each name count for each other word tells how many are wrong; and so many are taken (pruning by noise
/// rate), those first that are surest of the other word. Only samples that are surer of the other word than
/// of their name are. `names` are words 0 … K − 1, `heldOut` N × K probabilities; rows that are all 0 are not
/// judged. Ascending. Throws Error when the numbers of samples differ.
std::vector<std::size_t> likelyMisnamed(const std::vector<int>& names, const DescriptorMatrix& heldOut);

}  // namespace estancia
