// Scene rankings: which scene classifiers differ (thesis 3.5.1, Table 3.2, Fig. 3.10).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/findings/findings.hpp"
#include "scenes/scenes_findings.hpp"

namespace estancia::experiments {

/// Adds Friedman's test with Holm's correction over all cells, over the descriptors and over the classifiers,
/// and, where it is asked for, the thesis' own table. Files of their own begin with `prefix`.
void addRankings(const ScenesResults& results, const std::string& prefix, Findings& findings);

}  // namespace estancia::experiments
