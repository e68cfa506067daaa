// Which scene classifiers differ, with the tests of the thesis (3.5.1, Table 3.2, Fig. 3.10).
#pragma once

#include "estancia/core/findings.hpp"
#include "estancia/experiment/scenes_findings.hpp"

namespace estancia {

/// Adds Friedman's test with Holm's correction over all cells, over the descriptors and over the classifiers,
/// and beside it the thesis' own table.
void addRankings(const ScenesResults& results, Findings& findings);

}  // namespace estancia
