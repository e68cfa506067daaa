// What the cells of a model choice say together.
#pragma once

#include <string>
#include <vector>

#include "experiments/src/findings/findings.hpp"
#include "experiments/src/places/place_recognition.hpp"
#include "experiments/src/places/spatial_variance.hpp"
#include "experiments/src/runner/grid.hpp"

namespace estancia::experiments {

/// What one model reached on one sequence by one distance.
struct ModelChoiceCell {
  std::vector<SpatialVariance> variance;  ///< inside clusters for k = 1, 2, …
  PlaceRecognition recognition;

  static std::vector<std::string> measures();
  CellResults toResults() const;
  static ModelChoiceCell fromResults(const CellResults& results);
};

struct ModelChoiceResults {
  struct Drive {
    std::string name;
    std::size_t frames = 0;  ///< with a pose
    double radius = 0;       ///< of a place [m]
    bool again = false;      ///< another drive asks for the places of this one
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

}  // namespace estancia::experiments
