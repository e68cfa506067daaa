// Heat table: a matrix in the colors of viridis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/figures/html.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia {

/// A table in the colors of viridis, from the smallest value to the largest, with a scale below. Values are
/// printed where there are at most 20 names, and shown on hovering in any case.
report::Markup matrixTable(const HeatTable& matrix);

/// The style of a cell in such a table: its color, and ink that reads well on it in any mode. `t` in [0, 1].
std::string heatStyle(double t);

/// The colors, between texts for the two ends.
report::Markup heatScale(const std::string& least, const std::string& most);

}  // namespace estancia
