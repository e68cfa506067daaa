// Color recognition experiment: does color help to recognize objects where shape is ambiguous?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "recognition/color_cases.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ColorRecognitionOptions {
  /// What differs from the defaults of recognition.
  struct Condition {
    std::string name, descriptor = "shot", sceneFilter = "none";
    double colorTolerance = 0, colorWeight = 0;
  };
  struct Drive {
    std::string name;
    DriveCasesOptions cases;
  };
  std::vector<Condition> conditions;
  std::vector<Drive> drives;
  /// Made-up scenes of each kind.
  std::size_t lookAlikes = 8;
  /// Largest error of a correct pose [m, degrees].
  double translation = 0.02, rotation = 15;
  /// Neurons of a filtered scene.
  std::size_t points = 20000;
  /// Weights of color in a neural gas, for the table of its errors.
  std::vector<double> colorWeights = {0, 0.3, 1, 3};
  std::uint64_t seed = 1;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ColorRecognitionOptions readColorRecognition(ConfigFile& config);

/// set,condition,part,pairs,found,right,correct,absent,false_positives,failed,seconds,scene_seconds …
GridColumns colorRecognitionColumns();

/// Looks for each model of the cases in a scene that holds it and in one that does not; the best detection
/// counts. Throws Error as casesOfDrive() does.
Findings compareColors(const ColorRecognitionOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress);

}  // namespace estancia::experiments
