// Line chart: curves over a common axis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "estancia/figures/html.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia {

/// The classes that color and dash the i-th of many curves: seven colors, then other dashes; 28 in all.
std::string curveClass(std::size_t i);

/// A figure with legend, axes and caption. A curve breaks where its value is not finite.
report::Markup lineChart(const LineChart& chart);

}  // namespace estancia
