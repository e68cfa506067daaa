// What the cells of the recognition experiment say together.
#pragma once

#include "estancia/core/findings.hpp"
#include "estancia/experiment/recognition_results.hpp"

namespace estancia {

Findings findingsOf(const RecognitionResults& results);

}  // namespace estancia
