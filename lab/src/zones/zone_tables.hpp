// Zone tables experiment: every model, distance, linkage and cut against known rooms (thesis 5.5: Tables 5.2
// and 5.3, Fig. 5.4). docs/how-to/zones.md shows the tables that it makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

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
    /// CSV with a header, one line an image; "": the sequence knows the rooms.
    std::filesystem::path table;
    std::string imageColumn = "image", roomColumn = "room";
    /// The column that names the class. "": images that follow each other, in one room, are a class …
    std::string classColumn;
    /// Images of a class also have the same value of this column, if one is named.
    std::string runColumn;
    /// Each class is cut into so many equal parts, each a class of its own.
    std::size_t parts = 1;
    /// One of labelOrders(), and what it shuffles by.
    std::string labelOrder = "network";
    std::uint64_t orderSeed = 1;
    /// These rooms; none: all.
    std::vector<std::string> only;
    /// Left out, with a note, when it is not there.
    bool optional = false;
  };
  /// The cut that the data suggests.
  static constexpr const char* automatic = "auto";
  /// The one of the largest V-measure: with the truth in view.
  static constexpr const char* best = "best";

  /// The first one stands for all in figures; none: all installed.
  std::vector<std::string> models;
  /// Left out, with a note, where they are not installed.
  std::vector<std::string> optionalModels;
  /// None: all between two images.
  std::vector<std::string> distances;
  /// None: all.
  std::vector<std::string> linkages;
  /// Numbers are τ_d.
  std::vector<std::string> cuts{"0.2", "0.35", "0.5", "0.65", "0.8", automatic, best};
  /// The best cut leaves at most so many zones. Without a bound, zones of one image each would often be best:
  /// homogeneous, and V-measure forgives them much.
  std::size_t maxZones = 60;
  /// Instead of a table a measure: one of V-measures and one of zones by each cut, a row each data, model,
  /// distance and linkage.
  bool eachCut = false;
  /// The thesis' Tables 5.2 and 5.3 beside.
  bool thesisTables = false;
  /// At least one.
  std::vector<Data> data;
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
