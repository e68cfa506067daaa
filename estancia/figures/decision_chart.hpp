// Decision chart: the decisions of the mapper over time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/svg.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia::report {

/// Points (i, values[i]) for a line `columns` wide: all while there are at most two a column, else each
/// column's least and largest in their order, so that no peak is lost. NaN where the line breaks.
std::vector<Point> thinned(const std::vector<double>& values, std::size_t columns);

/// A figure: D(current) and D(other) with both thresholds, splits, revisits and merges marked, and a legend.
Markup decisionChart(const TopologicalMap& map);

}  // namespace estancia::report
