// What the thesis measured of its zones, to be printed beside ours. Its data is ViDRILO, ours is not.
#pragma once

#include <string>
#include <vector>

#include "experiments/src/findings/findings.hpp"

namespace estancia::experiments {

/// Table 5.2: the values of τ_d …
const std::vector<std::string>& thesisCuts();

/// … and for each of them the number of zones.
struct ThesisZoneCounts {
  std::string name;  ///< model and sequence
  std::vector<double> zones;
};
const std::vector<ThesisZoneCounts>& thesisZoneCounts();

/// Table 5.3, with M in its last row.
ResultTable thesisWithin();

}  // namespace estancia::experiments
