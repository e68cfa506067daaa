// The map for other programs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "estancia/topology/map.hpp"

namespace estancia {

struct ExportOptions {
  std::size_t words = 10;     ///< how many of a place's best labels go along
  std::string frame = "map";  ///< nav2: the coordinate frame of the poses, as the robot's TF tree names it
  bool bidirectional = true;  ///< nav2: an edge each way for every transition; false: only as it was driven
};

/// GraphML 1.0: nodes with words, room (the true one), predicted_room and room_probability (a classifier's),
/// x, y, z [m] and frames, directed edges with counts. What is not known is left out.
std::string toGraphml(const TopologicalMap& map, const ExportOptions& options = {});

/// Places → words: {"format": "estancia-places", "version": 1, "vocabulary": digest, "model", "distance",
/// "places": [{"id", "words": [{"label", "p"}], "room", "position": [x, y, z], "frames",
/// "predicted_rooms": [{"room", "p"}]}],
/// "transitions": [{"from", "to", "count"}]}. Unknown rooms and positions are null; predicted
/// rooms, best first, are there when a classifier has named them.
std::string toPlacesJson(const TopologicalMap& map, const ExportOptions& options = {});

/// The GeoJSON that the route server of Nav2 (nav2_route, GeoJsonGraphFileLoader) reads: nodes as points with
/// metadata (class = true or predicted room or best label, labels, probabilities, frames), edges as lines
/// whose cost is their length [m]. Throws Error when a node has no position or there is no transition: Nav2
/// refuses such graphs.
std::string toNav2(const TopologicalMap& map, const ExportOptions& options = {});

/// The names for exportMap(), each with one line of explanation.
std::vector<std::pair<std::string, std::string>> exportFormats();

/// Throws Error on an unknown format, listing the known ones.
std::string exportMap(const TopologicalMap& map, const std::string& format,
                      const ExportOptions& options = {});

/// Writes the file whole or not at all. Throws Error.
void exportMap(const TopologicalMap& map, const std::string& format, const std::filesystem::path& path,
               const ExportOptions& options = {});

}  // namespace estancia
