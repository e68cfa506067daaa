// World view: a world prepared for drawing: positions on the floor, images, ways.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "estancia/core/pose.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/svg.hpp"
#include "estancia/report/page_contents.hpp"
#include "estancia/world_query/route_world.hpp"

namespace estancia::report {

struct WorldView {
  const WorldMap& world;
  Floor floor;
  /// One a frame, in the floor's axes [m]; none where the pose is unknown or absurd.
  std::vector<std::optional<Point>> path = {};
  std::vector<std::size_t> driveStarts = {};   ///< frames before which the robot may have been carried
  std::vector<std::vector<Point>> boxes = {};  ///< boxOnFloor() of each object
  std::map<int, std::string> images = {};      ///< the data: URI of each object that has an image
  std::size_t withheld = 0;                    ///< images left out because WorldPage::bytes were used up
  int from = -1;                               ///< the node where ways start; -1 in a map without places
  std::vector<std::optional<WorldRoute>> routes = {};      ///< for each object
  std::vector<std::optional<WorldRoute>> areaRoutes = {};  ///< for each area

  Point centerOf(const WorldObject& object) const;
  /// Where the ways start; nothing where none is known.
  std::optional<Point> start() const;
};

Point onFloor(const Floor& floor, const cv::Vec3d& at);

/// The corners of an object's box on the floor [m]; none where it is absurdly far away, as in a damaged map.
std::vector<Point> boxOnFloor(const WorldObject& object, const Floor& floor);

/// Whether there is anything to draw above the places.
bool hasLayers(const WorldMap& world);

/// Throws Error (unknownName) where there is no node WorldPage::from.
WorldView viewOf(const WorldPage& page);

/// The tint of an area: 21 differ.
Color areaColor(int area);

/// The images as symbols "image-<object>" of 1 × 1, for <use>.
Markup imageSymbols(const WorldView& view);

/// "61 %"; "named by people", or "" where nothing is known.
std::string probabilityText(const WorldObject& object);

/// "on the dining table, in kitchen"; "" where nothing is known.
std::string whereText(const WorldObject& object, const WorldMap& world);

}  // namespace estancia::report
