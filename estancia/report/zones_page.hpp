// The page of semantic zones: one HTML file that needs nothing else and no network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/figures/floor_plan.hpp"
#include "estancia/report/page_contents.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// Everything the page shows. Texts may hold anything; they are escaped.
struct ZonesPage {
  const Zones& zones;  ///< must outlive the rendering
  std::string title = "A run and its zones";
  std::string date = {};               ///< shown as it is; "" keeps pages reproducible
  std::vector<Measure> measures = {};  ///< shown in this order
  /// Drawn under the zones; needs poses in a z-up map.
  std::optional<FloorPlan> floorPlan = {};
  /// installedConcepts() of the zones' vocabulary: familiar words for several labels; without, each for
  /// itself.
  const LabelConcepts* concepts = nullptr;
  PageImages images = {};  ///< by the numbers of Zones::frames
  std::size_t cards = 60;  ///< only this many of the largest zones get images and words
};

/// The whole page. Equal input gives equal bytes. Throws Error when the floor plan cannot be used.
std::string renderZonesPage(const ZonesPage& page);

/// Renders and writes the page beside `path`, then renames it. Throws Error as above, and when it cannot be
/// written.
void writeZonesPage(const std::filesystem::path& path, const ZonesPage& page);

}  // namespace estancia
