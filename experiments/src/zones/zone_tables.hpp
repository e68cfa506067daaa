// Zones by every model, distance, linkage and cut, against rooms that are known (thesis 5.5: Tables 5.2
// and 5.3, Fig. 5.4). docs/how-to/zones.md shows the tables that it makes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "experiments/src/findings/findings.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "experiments/src/runner/grid.hpp"
#include "experiments/src/runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ZoneTablesOptions {
  /// Images whose rooms are known, and the classes within a room's category (corridor 1, corridor 2 …) that M
  /// compares. Images without a room are left out.
  struct Data {
    std::string name;
    SequenceSource images;
    std::filesystem::path table;  ///< CSV with a header, one line an image; "": the sequence knows the rooms
    std::string imageColumn = "image", roomColumn = "room";
    /// The column that names the class. "": images that follow each other, in one room, are a class …
    std::string classColumn;
    std::string runColumn;          ///< … and have the same value of this column, if one is named
    std::size_t parts = 1;          ///< … cut into so many equal parts, each a class of its own
    std::vector<std::string> only;  ///< these rooms; none: all
    bool optional = false;          ///< left out, with a note, when it is not there
  };
  static constexpr const char* automatic = "auto";  ///< the cut that the data suggests
  static constexpr const char* best = "best";  ///< the one of the largest V-measure: with the truth in view

  std::vector<std::string> models;          ///< the first one stands for all in figures; none: all installed
  std::vector<std::string> optionalModels;  ///< left out, with a note, where they are not installed
  std::vector<std::string> distances;       ///< none: all between two images
  std::vector<std::string> linkages;        ///< none: all
  std::vector<std::string> cuts{"0.2", "0.35", "0.5", "0.65", "0.8", automatic, best};  ///< numbers are τ_d
  /// The best cut leaves at most so many zones. Without a bound, zones of one image each would often be best:
  /// homogeneous, and V-measure forgives them much.
  std::size_t mostZones = 60;
  std::vector<Data> data;  ///< at least one
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ZoneTablesOptions readZoneTables(ConfigFile& config);

/// data,model,distance,linkage,cut,zones,v_measure,ari,purity,m
GridColumns zoneTablesColumns();

/// Runs the experiment. Throws Error when a model, or data that is not optional, cannot be opened, or nothing
/// is left to compare.
Findings compareZones(const ZoneTablesOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress);

}  // namespace estancia::experiments
