// Label subsets: accuracy of a descriptor with fewer labels (thesis 3.5.3).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/findings/findings.hpp"
#include "scenes/scenes_findings.hpp"

namespace estancia::experiments {

// All of them need results.curves.

/// Fig. 3.11: accuracy by the number of labels, a line a rule that selects them.
LineChart subsetCurve(const ScenesResults& results);
ResultTable subsetTable(const ScenesResults& results);

/// Whether the thesis' finding, that 75 labels beat all, holds: a sentence; "" where 75 or all were not
/// tried.
std::string subsetAnswer(const ScenesResults& results);

}  // namespace estancia::experiments
