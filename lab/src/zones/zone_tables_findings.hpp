// Zone findings: tables and charts of zones against rooms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "runner/grid.hpp"

namespace estancia::experiments {

/// The zones that one cut of a dendrogram makes, against the rooms.
struct ZoneReading {
  /// The configured value: "0.5", "auto".
  std::string cut;
  std::size_t zones = 0;
  double vMeasure = 0, adjustedRandIndex = 0, purity = 0;
  /// Eq. 5.2; absent where no category has two classes.
  std::optional<double> m;
  /// What M is the mean of, by pair or by category.
  std::vector<std::pair<std::string, double>> within;
};

/// One dendrogram: a model, on some data, by a distance and a linkage.
struct ZoneCell {
  std::vector<ZoneReading> readings;
  /// With 1, 2, … zones.
  std::vector<double> vMeasures;

  const ZoneReading* find(const std::string& cut) const;
  /// The maximum of vMeasures.
  double bestV() const;

  /// Measures in results.csv.
  static std::vector<std::string> measures();
  CellResults toResults() const;
  static ZoneCell fromResults(const CellResults& results);
};

/// How far classes lie apart: the distance of their mean descriptors (Fig. 5.4), or the mean distance of an
/// image of the one and an image of the other.
struct ClassMatrix {
  std::string distance;
  bool ofMeans = false;
  /// Row-major; NaN where unknown.
  std::vector<double> values;
};

struct ZoneTablesResults {
  struct Data {
    std::string name;
    std::size_t images = 0;
    /// Their names.
    std::vector<std::string> rooms;
    /// Number of classes over all rooms.
    std::size_t classes = 0;
    /// Rows of the matrices: classes, or the rooms where they are many.
    std::vector<std::string> matrixNames;
    /// Mean over the models.
    std::vector<ClassMatrix> matrices;
    /// How the classes spread over the zones; absent where Eq. 5.1 is not compared.
    std::optional<ResultTable> histograms = std::nullopt;
  };
  std::vector<Data> data;
  /// Mean over the data, too, where all have the same classes.
  std::vector<ClassMatrix> matrices;
  std::vector<std::string> models, distances, linkages, cuts;
  /// cells[((data · models + m) · distances + d) · linkages + l]; absent where the two do not fit
  std::vector<std::optional<ZoneCell>> cells;
  /// The thesis' Tables 5.2 and 5.3 beside.
  bool thesisTables = false;
  /// V-measure and zones by each cut, a row each cell.
  bool eachCut = false;

  const ZoneCell* find(std::size_t data, std::size_t model, const std::string& distance,
                       const std::string& linkage) const;
};

Findings findingsOf(const ZoneTablesResults& results);

}  // namespace estancia::experiments
