// Recognition tables: the layout of the thesis (Tables 2.2 to 2.17), its numbers beside where they are asked
// for. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/findings/findings.hpp"
#include "recognition/recognition_results.hpp"

namespace estancia::experiments {

/// Table 2.17 in all scores, for each preset.
void addOverall(const RecognitionResults& results, Findings& findings);

/// Tables 2.2 to 2.16: for each descriptor its detectors one by one, and their means.
void addByDetector(const RecognitionResults& results, Findings& findings);

}  // namespace estancia::experiments
