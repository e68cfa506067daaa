// Recognition by noise: overviews and curves of the recognition experiment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/findings/findings.hpp"
#include "recognition/recognition_results.hpp"

namespace estancia::experiments {

/// What did best without noise, or with the least, and with the most.
std::string bestByNoise(const RecognitionResults& results);

/// Everything that was compared in rows, the noise in columns, where that is not too much.
void addOverviews(const RecognitionResults& results, Findings& findings);

/// Fig. 2.6–2.8, in the honest score.
void addCurves(const RecognitionResults& results, Findings& findings);

}  // namespace estancia::experiments
