// Maps experiment: sequences mapped with many thresholds, measured and drawn side by side (thesis 4.5.3, Fig.
// 4.6), and each sequence's images found in the map of one of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

/// How a map is made.
struct MapSetting {
  std::string preset;
  MapperOptions mapper;
  /// Whether the thresholds are the preset's own.
  bool isPresets = true;

  /// Preset, τ_join, τ_revisit; "auto" where the run itself gives the threshold.
  std::vector<std::string> coordinates() const;
};

struct MapsOptions {
  struct Drive {
    NamedDrive itself;
    /// Drawn under its maps: a home.json, or an image with its extent (FloorPlan).
    std::filesystem::path floorPlan = {};
    std::optional<std::array<double, 4>> extent = {};
  };

  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Drive> sequences;
  /// The presets with their own thresholds, each followed by its sweep; no two are equal.
  std::vector<MapSetting> settings;
  /// The images of all sequences are found in the map of this one; "": in none.
  std::string reference;
  /// X of the original score [m]; without, the extent of each sequence.
  std::optional<double> scoreExtent;
  /// The thesis author's own sweeps and localization beside, where he has a sequence of that name.
  bool thesisTables = false;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
MapsOptions readMaps(ConfigFile& config);

/// model,sequence,preset,tau_join,tau_revisit and the measures of a map.
GridColumns mapsColumns();

/// Throws Error when a model, or a sequence that is not optional, cannot be opened.
Findings compareMaps(const MapsOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress);

/// The share of the posed images whose nearest node by words is the one nearest by meters, as the author
/// counted it: a node lies where its image nearest to the median of their x and y was taken. Nothing without
/// posed images or nodes.
std::optional<double> shareFound(const DescriptorSequence& images, const LocalizerMap& map);

}  // namespace estancia::experiments
