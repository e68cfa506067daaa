// A matrix as heat.
#pragma once

#include "estancia/core/findings.hpp"
#include "estancia/report/html.hpp"

namespace estancia::report {

/// A table in the colours of viridis, from the smallest value to the largest, with a scale below. Values are
/// printed where there are at most 20 names, and are told on hovering in any case.
Markup matrixTable(const Matrix& matrix);

}  // namespace estancia::report
