// Optimal assignment: the one-to-one assignment of rows to columns of the greatest sum (Kuhn, 1955).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

namespace estancia::experiments {

/// Pairs of row and column, ascending by row; as many as there are rows or columns, whichever are fewer.
/// `gain`: finite.
std::vector<std::pair<std::size_t, std::size_t>> optimalAssignment(const cv::Mat_<double>& gain);

}  // namespace estancia::experiments
