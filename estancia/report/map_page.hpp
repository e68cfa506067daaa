// The page of a topological map: one HTML file that needs nothing else and no network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/figures/floor_plan.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/report/page_contents.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

class Lexicon;
struct WordAssociation;

/// Everything the page shows. Texts may hold anything; they are escaped.
struct MapPage {
  const TopologicalMap& map;  ///< must outlive the rendering
  std::string title = "A topological map in words";
  std::string sequence = {};                ///< where the images came from, "" if unknown
  std::string date = {};                    ///< shown as it is; "" keeps pages reproducible
  std::vector<Measure> measures = {};       ///< shown in this order
  std::optional<std::size_t> label = {};    ///< the map starts as this label's heat map
  std::optional<FloorPlan> floorPlan = {};  ///< needs poses in a z-up map
  const Zones* zones = nullptr;             ///< zones of the same run, to lay over the nodes
  PageImages images = {};
  /// installedConcepts() of the map's vocabulary: familiar words for several labels; without, each for
  /// itself.
  const LabelConcepts* concepts = nullptr;
  /// world of the same map: a floor plan with areas and objects comes first
  const WorldPage* world = nullptr;

  std::size_t cards = 60;  ///< only this many of the largest nodes get images and a word cloud
  /// Values in the search index; smaller probabilities are left out first.
  std::size_t indexEntries = 200'000;
  /// installedAssociations() of the map's vocabulary: the search understands words that no label has.
  const std::vector<WordAssociation>* words = nullptr;
  /// The words that are known at all, so that none of them is taken for a misspelled one.
  const Lexicon* lexicon = nullptr;
  /// About what they take at most.
  std::size_t wordBytes = 360'000;
};

/// The whole page. Equal input gives equal bytes. Throws Error when page.label is not in the vocabulary, the
/// floor plan cannot be used (without poses; most of the frames lie in none of its rooms), or the zones are
/// of another run.
std::string renderMapPage(const MapPage& page);

/// Renders and writes the page beside `path`, then renames it. Throws Error, also when it cannot be written.
void writeMapPage(const std::filesystem::path& path, const MapPage& page);

}  // namespace estancia
