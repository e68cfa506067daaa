// What the thesis measured of its classifiers, to be printed beside ours. Its data is ViDRILO, ours is not.
#pragma once

#include "experiments/src/findings/findings.hpp"

namespace estancia::experiments {

/// Table 3.2: all combinations against the best one.
ResultTable thesisScenes();

}  // namespace estancia::experiments
