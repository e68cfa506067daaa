// Feature study: places mapped by words, by inner layers of networks and by traditional image features
// (thesis 4.6). docs/measured/features.md shows the tables that it makes. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "features/feature_labeler.hpp"
#include "features/layer_figures.hpp"
#include "places/localization_errors.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct FeatureStudyOptions {
  /// An inner layer of a network, as a descriptor.
  struct Layer {
    std::string name;
    /// For getModelFolder().
    std::string model;
    /// A value inside of its network, ≥ 0, and how many numbers that is.
    std::string output;
    std::size_t features = 0;
  };
  /// Images whose rooms a classifier learns, and others that it is asked about.
  struct Rooms {
    NamedDrive learned;
    SequenceSource asked;
  };

  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Layer> layers;
  /// Drawn for the first image of the first drive.
  std::vector<ShownLayer> shownLayers;
  /// Names of featureTypes().
  std::vector<std::string> features;
  /// "orb", "sift": FAB-MAP by visual words of these, for drives alone; none: without it.
  std::vector<std::string> fabMaps;
  /// Names of distances(); none: the default of the maps.
  std::vector<std::string> distances;
  /// Random orders of the stays in rooms of a drive, which are mapped beside its own: one order is one draw.
  std::size_t orders = 0;
  /// Images that visual vocabularies are learned from, none of which should be mapped; absent: features that
  /// need them are refused.
  std::optional<NamedDrive> vocabulary;
  VocabularySizes sizes;
  /// The first one chooses each descriptor's distance.
  std::vector<LocalizationErrorsOptions::Drive> drives;
  std::vector<Rooms> rooms;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
FeatureStudyOptions readFeatureStudy(ConfigFile& config);

/// descriptor,task,distance,nodes,v_measure, …
GridColumns featureStudyColumns();

/// Maps each drive by each descriptor and distance, finds the other drive in it, and trains a classifier on
/// each set of rooms. Maps and localizes by images alone, poses only judge; all else as the defaults are.
/// Throws Error when a model, or images that are not optional, cannot be opened.
Findings compareFeatures(const FeatureStudyOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress);

/// What was found, as plain data.
struct FeatureResults {
  struct Task {
    std::string name;
    bool isDrive = true;
  };
  std::vector<std::string> descriptors, distances;
  /// The drives first.
  std::vector<Task> tasks;
  /// cells[descriptor][task][distance]; of rooms, one.
  std::vector<std::vector<std::vector<CellResults>>> cells;
  /// What finds drives but makes no maps: its name, and a cell a drive.
  std::vector<std::pair<std::string, std::vector<CellResults>>> recognizers = {};
};

/// Measures of drives, and columns for people.
std::vector<std::pair<std::string, ResultTable::Column>> featureMeasures();

Findings featureFindings(const FeatureResults& results);

}  // namespace estancia::experiments
