// What the thesis measured of objects that label themselves (6.4): eight objects, three instances of each, of
// which two are learned from and one is tested. Its data was never published.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/src/findings/findings.hpp"

namespace estancia::experiments {

/// Accuracies [%] of the baseline split (6.4.3), and of 30 random splits (6.4.4, Fig. 6.7).
struct ThesisObjects {
  double labeler = 57.1, baseline = 93.5, mean = 84.55, best = 95.8, worst = 76.0;
};

/// The same as a table, with the five worst splits (Table 6.8).
ResultTable thesisObjectsTable();

}  // namespace estancia::experiments
