// Home plan: the rooms of a floor as polygons with their doors and windows, from `home.json`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace estancia::io {

/// Coordinates are x and y of the map [m].
struct HomeRoom {
  std::string name;
  /// At least three corners, in order, the last one linked to the first.
  std::vector<cv::Point2f> polygon;
};

/// A door or window: an opening in a wall that runs along x or y.
struct HomeOpening {
  /// Its middle [m].
  cv::Point2f at;
  bool alongX = true;
  /// [m]
  float width = 0;
  /// Names of the rooms that it opens: two of a door, one of a window or of a door that leads outside.
  std::vector<std::string> rooms;
};

struct HomePlan {
  std::string name;
  /// At least one; no two of one name.
  std::vector<HomeRoom> rooms;
  std::vector<HomeOpening> doors, windows;
};

/// Reads JSON `{"name", "rooms": [{"name", "polygon": [[x, y] …]}], "doors": [{"at": [x, y], "axis": "x" |
/// "y", "width", "rooms": [name, name]}], "windows": [{… "room": name}]}`; name, doors and windows may be
/// missing, other keys are not read. Throws Error: no JSON, a key missing or of another type (malformedFile,
/// naming the element), polygons of fewer than three corners or without area, coordinates that are not finite
/// or beyond 10 km, two rooms of one name, openings of unknown rooms, more than 1,000 rooms or corners.
HomePlan readHomePlan(const std::filesystem::path& file);

/// The room whose polygon holds (x, y) [m] or has it on its edge; the first where several do.
std::optional<std::size_t> roomAt(const HomePlan& plan, double x, double y);

}  // namespace estancia::io
