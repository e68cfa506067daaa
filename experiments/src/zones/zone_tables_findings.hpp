// What the cells of the zones' tables say together.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/src/findings/findings.hpp"
#include "experiments/src/runner/grid.hpp"

namespace estancia::experiments {

/// The zones that one cut of a dendrogram makes, against the rooms.
struct ZoneReading {
  std::string cut;  ///< as configured: "0.5", "auto" …
  std::size_t zones = 0;
  double vMeasure = 0, adjustedRandIndex = 0, purity = 0;
  std::optional<double> m;                             ///< Eq. 5.2; absent where no category has two classes
  std::vector<std::pair<std::string, double>> within;  ///< what M is the mean of, by pair or by category
};

/// One dendrogram: a model, on some data, by a distance and a linkage.
struct ZoneCell {
  std::vector<ZoneReading> readings;
  std::vector<double> vMeasures;  ///< with 1, 2, … zones

  const ZoneReading* find(const std::string& cut) const;
  double bestV() const;  ///< of vMeasures

  static std::vector<std::string> measures();  ///< those that results.csv shows
  CellResults toResults() const;
  static ZoneCell fromResults(const CellResults& results);
};

/// The mean distance of an image of one class and an image of another (Fig. 5.4).
struct ClassMatrix {
  std::string distance;
  std::vector<double> mean;  ///< row-major; NaN where unknown
};

struct ZoneTablesResults {
  struct Data {
    std::string name;
    std::size_t images = 0;
    std::vector<std::string> rooms;  ///< their names
    std::size_t classes = 0;         ///< of all rooms
    /// Rows of the matrices: classes, or the rooms where they are many.
    std::vector<std::string> matrixNames;
    std::vector<ClassMatrix> matrices;  ///< mean over the models
  };
  std::vector<Data> data;
  std::vector<std::string> models, distances, linkages, cuts;
  /// cells[((data · models + m) · distances + d) · linkages + l]; absent where the two do not fit
  std::vector<std::optional<ZoneCell>> cells;

  const ZoneCell* find(std::size_t data, std::size_t model, const std::string& distance,
                       const std::string& linkage) const;
};

Findings findingsOf(const ZoneTablesResults& results);

}  // namespace estancia::experiments
