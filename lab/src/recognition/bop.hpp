// BOP experiment: known objects in the images of BOP data sets, judged by the measures of the BOP challenge.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "recognition/bop_data.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct BopOptions {
  std::vector<BopSource> sources;
  std::string preset = "default";
  /// RecognitionOptions::falseAlarmRate. What is looked for is there, and nothing but recall counts.
  double falseAlarmRate = 0.1;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
BopOptions readBopOptions(ConfigFile& config);

/// dataset,scene,image,object,targets,estimates,vsd,mssd,mspd
GridColumns bopColumns();

/// Looks for the targets of each image (6D localization of the challenge of 2019), judges what is found, and
/// writes it as FOLDER/estancia_DATASET-SPLIT.csv. Throws Error as readBop() does.
Findings compareWithBop(const BopOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress);

}  // namespace estancia::experiments
