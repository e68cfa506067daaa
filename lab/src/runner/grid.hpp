// Experiment grid: cells that are each computed once and kept on disk.
// SPDX-License-Identifier: Apache-2.0
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
class WorkQueue;
}

namespace estancia::experiments {

/// One number that a cell found: `measure`, or `measure` at one of the points that the cell was read at.
struct CellResult {
  std::string measure;
  /// A number of clusters, the name of a threshold …; "" where there is but one.
  std::string at;
  double value = 0;
};
using CellResults = std::vector<CellResult>;

/// The first result of this measure at this point; nothing where there is none.
std::optional<double> valueOf(const CellResults& results, const std::string& measure,
                              const std::string& at = "");

/// The head of results.csv, in snake_case.
struct GridColumns {
  /// Coordinates that distinguish the cells: model, sequence.
  std::vector<std::string> coordinates;
  /// Coordinate that distinguishes the rows of one cell; "" if each has but one.
  std::string at;
  /// Results that are shown there.
  std::vector<std::string> measures;
  /// All of them as they stand there; empty: as they are listed here.
  std::vector<std::string> order = {};
};

struct Cell {
  /// One a column of the grid: model, sequence.
  std::vector<std::string> coordinates;
  /// A digest of all that the results depend on; where it differs they are found anew.
  std::string inputs;
};

/// Keeps FOLDER/cells, a small file a cell. Results must depend on nothing but the cell (seeds included), so
/// neither order nor number of threads matter. A cell's file that is damaged, or of another version, counts
/// as absent. An interrupted grid goes on where it stopped.
class Grid {
 public:
  /// `threads` = 0 takes one a usable core, or a single one where several processes share the cells by
  /// `distribution`: these have the folder in common, and the first of them writes the table. The folder is
  /// made by run().
  Grid(std::filesystem::path folder, GridColumns columns, int threads = 0, WorkQueue* distribution = nullptr);

  /// Makes the folder, before anything long is begun. Throws Error when it cannot be made or written.
  void makeFolder() const;

  /// Cells of the next runs come from this file, for errors.
  void setSource(const std::string& source) { source_ = source; }

  /// Whether the results of the cell are at hand.
  bool has(const Cell& cell);

  /// The results of the cells, in their order; `compute(i)` is called for those that are not at hand, by
  /// several threads at once. Its exception ends the run (of several, that of the first cell); the cells done
  /// until then are kept. Throws Interrupted when the user asks to stop, or `compute` does; Error when two
  /// cells of all runs have the same coordinates, or the folder cannot be made.
  std::vector<CellResults> run(const std::vector<Cell>& cells,
                               const std::function<CellResults(std::size_t)>& compute, Progress& progress,
                               const std::string& what);

  /// Adds a row to the table that is not computed, but put together from cells. Throws Error as run() does.
  void add(const std::vector<std::string>& coordinates, const CellResults& results);

  /// Writes FOLDER/NAME: all cells of all runs, in order, a row a cell and `at`; a measure that it does not
  /// have there is left empty.
  void writeCsv(const std::string& name = "results.csv") const;

 private:
  std::filesystem::path fileOf(const Cell& cell) const;
  std::optional<CellResults> load(const Cell& cell) const;
  void store(const Cell& cell, const CellResults& results) const;
  void name(const std::vector<std::string>& coordinates);
  void fetch(const Cell& cell);

  std::filesystem::path folder_;
  GridColumns columns_;
  std::size_t threads_;
  WorkQueue* distribution_;
  /// By file name.
  std::map<std::string, CellResults> known_;
  /// Coordinates of all cells → their source.
  std::map<std::vector<std::string>, std::string> named_;
  std::string source_;
  /// What run() returned.
  std::vector<std::pair<std::vector<std::string>, CellResults>> table_;
};

}  // namespace estancia::experiments
