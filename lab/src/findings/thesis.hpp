// Thesis tables: numbers that the thesis prints, to be shown beside ours (lab/experiments/thesis/*.csv).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"

namespace estancia::experiments {

// The files, compiled in by cmake/EstanciaExperiments.cmake. No cell is quoted; what is not printed is empty.

/// Tables 2.2 to 2.16: percent of 49 pairs that the verification accepts; "mean" of keypoint detectors, of
/// noises.
extern const std::string thesisRecognitionCsv;
/// Table 2.17: means over models, noises and sizes, by filter of the scene.
extern const std::string thesisRecognitionMeansCsv;
/// Table 3.2: descriptors and classifiers of rooms against the best combination.
extern const std::string thesisScenesCsv;
/// Table 4.1: spatial variance within k clusters [10⁻² m²].
extern const std::string thesisModelChoiceCsv;
/// The thesis author's sweeps of τ_join and τ_revisit with Hybrid-AlexNet on KTH-IDOL2's Minnie (a part of
/// github.com/jcarlos2289/TopoMapIdolMaven, resultados_WeigthDistance/*_MetricsData.txt); V-measure and
/// purity of his final maps, by the images that resultados/*_EdgesData.txt there have in each node.
extern const std::string lextomapSweepsCsv;
/// His localization in his map of Cloudy 1: the share of images whose nearest node by words is the nearest by
/// meters (counted in resultados/MapEvaluation_*.txt there).
extern const std::string lextomapLocalizationCsv;
/// Table 5.2: zones by τ_d.
extern const std::string thesisZonesCountsCsv;
/// Table 5.3, with M in its last row.
extern const std::string thesisZonesWithinCsv;
/// Accuracy [%] of the baseline split (6.4.3) and of 30 random splits (6.4.4, Fig. 6.7), five worst
/// (Table 6.8).
extern const std::string thesisObjectsCsv;

struct ThesisTable {
  struct Row {
    std::vector<std::string> keys;
    std::vector<std::optional<double>> values;  // one a column
    std::string name() const;                   // keys, joined by ", "
  };
  std::vector<std::string> keys, columns;
  std::vector<Row> rows;

  /// The value in the row of these keys; absent where there is no such row or column, or it is empty.
  std::optional<double> find(const std::vector<std::string>& rowKeys, const std::string& column) const;

  /// All rows under `head`, whose columns are these; where it has none they get the names of the file.
  ResultTable resultTable(ResultTable head) const;
};

/// Reads a file whose first `keys` columns are names, the others numbers.
ThesisTable readThesisTable(const std::string& csv, std::size_t keys);

}  // namespace estancia::experiments
