// What the recognition experiment found, in the tables of the thesis and beside them.
#pragma once

#include "estancia/core/findings.hpp"
#include "estancia/experiment/recognition_results.hpp"

namespace estancia {

/// Table 2.17 in both scores, beside the thesis', for each preset.
void addOverall(const RecognitionResults& results, Findings& findings);

/// Tables 2.2 to 2.16: for each descriptor its detectors one by one, and their means; each with the thesis'
/// below.
void addThesisTables(const RecognitionResults& results, Findings& findings);

}  // namespace estancia
