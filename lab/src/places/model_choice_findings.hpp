// Model choice findings: ranks of the models, tables and curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "places/place_recognition.hpp"
#include "places/spatial_variance.hpp"
#include "runner/grid.hpp"

namespace estancia::experiments {

/// What one model reached on one sequence by one distance.
struct ModelChoiceCell {
  /// Inside clusters for k = 1, 2,.
  std::vector<SpatialVariance> variance;
  PlaceRecognition recognition;

  static std::vector<std::string> measures();
  CellResults toResults() const;
  static ModelChoiceCell fromResults(const CellResults& results);
};

struct ModelChoiceResults {
  struct Drive {
    std::string name;
    /// With a pose.
    std::size_t frames = 0;
    /// Radius of a place [m].
    double radius = 0;
    /// Another drive asks for the places of this one.
    bool again = false;
  };
  std::vector<std::string> models, distances;
  std::vector<Drive> drives;
  /// cells[(d · drives + s) · models + m]
  std::vector<ModelChoiceCell> cells;

  const ModelChoiceCell& cell(std::size_t distance, std::size_t drive, std::size_t model) const {
    return cells[(distance * drives.size() + drive) * models.size() + model];
  }
};

/// Ranks the models; tables of the variances at the k of `shown` that all cells reach.
Findings findingsOf(const ModelChoiceResults& results, const std::vector<std::size_t>& shown);

/// The variances in the unit of the thesis' Table 4.1, with its rows below.
ResultTable besideThesis(const ModelChoiceResults& results);

}  // namespace estancia::experiments
