// Recognition findings: all tables and figures of the recognition experiment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/findings/findings.hpp"
#include "recognition/recognition_results.hpp"

namespace estancia::experiments {

Findings findingsOf(const RecognitionResults& results);

}  // namespace estancia::experiments
