// Average precision: how far ahead a ranking has what was asked for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace estancia::experiments {

/// The mean, over the answers, of the share of answers among all that score at least as much, in [0, 1].
/// Where scores are equal, the expected value over all orders of those (F. McSherry & M. Najork 2008:
/// Computing information retrieval performance measures efficiently in the presence of tied scores, ECIR).
/// `scores`: one an item, the largest first in the ranking; `answers`: items, each once. Throws Error
/// (invalidInput) without answers, or when one is no item.
double averagePrecision(const std::vector<double>& scores, const std::vector<std::size_t>& answers);

}  // namespace estancia::experiments
