// Method comparison: the result of compareMethods() as tables, rank diagrams and sentences.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/findings/findings.hpp"
#include "estancia/stats/method_comparison.hpp"

namespace estancia {

/// "p = 0.012", "p = 3.4e-05", "p < 1e-300": never 0.
std::string pText(double p);

/// The thesis' Table 3.2: a row a method, the best mean rank first, with p-value against the control, whether
/// it is rejected that both are equivalent, mean rank, and how often the control won, tied and lost.
ResultTable comparisonTable(const MethodComparison& comparison);

/// Everything: the answer in a sentence, Friedman's test among the facts, diagram and table, for tests of all
/// pairs their p-values (up to 40 methods), and notes on what not to trust.
Findings comparisonFindings(const MethodComparison& comparison);

}  // namespace estancia
