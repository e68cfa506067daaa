// The one runner of all experiments: a grid of cells, each computed once and kept on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"

namespace estancia {

/// One number that a cell found: `measure`, or `measure` at some point of a curve.
struct CellResult {
  std::string measure;
  std::optional<double> at;
  double value = 0;
};
using CellResults = std::vector<CellResult>;

struct Cell {
  std::vector<std::string> coordinates;  ///< one a column of the grid: model, sequence …
  std::string inputs;  ///< a digest of all that the results depend on; where it differs they are found anew
};

/// Keeps FOLDER/cells, a small file a cell. Results must depend on nothing but the cell (seeds included), so
/// neither order nor number of threads matter. A cell's file that is damaged, or of another version, counts
/// as absent. An interrupted grid goes on where it stopped.
class Grid {
 public:
  /// Makes the folder. `threads` = 0 takes one a free core. Throws Error when it cannot be made.
  Grid(std::filesystem::path folder, std::vector<std::string> columns, int threads = 0);

  /// Whether the results of the cell are at hand.
  bool has(const Cell& cell);

  /// The results of the cells, in their order; `compute(i)` is called for those that are not at hand, by
  /// several threads at once. Its exception ends the run (of several, that of the first cell); the cells done
  /// until then are kept. Throws Interrupted when the user asks to stop, or `compute` does.
  std::vector<CellResults> run(const std::vector<Cell>& cells,
                               const std::function<CellResults(std::size_t)>& compute, Progress& progress,
                               const std::string& what);

  /// Writes FOLDER/results.csv: the columns, `measure`, `at`, `value`; all cells of all runs, in order.
  void writeCsv() const;

 private:
  std::filesystem::path fileOf(const Cell& cell) const;
  std::optional<CellResults> load(const Cell& cell) const;
  void store(const Cell& cell, const CellResults& results) const;

  std::filesystem::path folder_;
  std::vector<std::string> columns_;
  std::size_t threads_;
  std::map<std::string, CellResults> known_;                             ///< by file name
  std::vector<std::pair<std::vector<std::string>, CellResults>> table_;  ///< what run() returned
};

}  // namespace estancia
