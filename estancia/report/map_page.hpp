// The page of a topological map: one HTML file that needs nothing else and no network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/io/home_plan.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/report/page_images.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// A drawing of the building under the map: an image, or rooms with doors and windows.
struct FloorPlan {
  std::vector<unsigned char> image;               ///< a JPEG, PNG, GIF or WebP file
  double xMin = 0, yMin = 0, xMax = 0, yMax = 0;  ///< what its edges are in the map [m]; y grows upwards
  std::optional<io::HomePlan> home = {};          ///< drawn instead of the image
};

/// Reads the image. `extent` is xMin, yMin, xMax, yMax [m].
/// Throws Error when it cannot be read, is no image, is larger than 8 MB, or the extent is empty.
FloorPlan readFloorPlan(const std::filesystem::path& path, const std::array<double, 4>& extent);

/// Reads a home.json, or that of a folder (io::readHomePlan()); its own coordinates are those of the map.
FloorPlan readHomeFloorPlan(const std::filesystem::path& path);

/// Everything the page shows. Texts may hold anything; they are escaped.
struct MapPage {
  const TopologicalMap& map;  ///< must outlive the rendering
  std::string title = "A topological map in words";
  std::string sequence = {};                ///< where the images came from, "" for not said
  std::string date = {};                    ///< shown as it is; "" keeps pages reproducible
  std::vector<Measure> measures = {};       ///< shown in this order
  std::optional<std::size_t> label = {};    ///< the map starts as this label's heat map
  std::optional<FloorPlan> floorPlan = {};  ///< needs poses in a z-up map
  const Zones* zones = nullptr;             ///< of the same run, to lay over the nodes
  PageImages images = {};

  std::size_t cards = 60;  ///< only this many of the largest nodes get images and a word cloud
  /// Values in the search index; smaller probabilities are left out first.
  std::size_t indexEntries = 200'000;
};

/// The whole page. The same input gives the same bytes.
/// Throws Error when page.label is not in the vocabulary, the floor plan cannot be used (without poses; most
/// of the frames lie in none of its rooms), or the zones are of another run.
std::string renderMapPage(const MapPage& page);

/// Renders and writes the page beside `path`, then renames it. Throws Error, also when it cannot be written.
void writeMapPage(const std::filesystem::path& path, const MapPage& page);

}  // namespace estancia
