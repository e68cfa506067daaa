// World section: the parts of a map's page that show areas and objects: what is drawn of them, the floor
// plan, what its script needs, a list. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>

#include "estancia/core/pose.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/driven_path.hpp"
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

/// A <section> "world": the page's search form, the floor plan for wide and narrow windows, and the panel
/// that world_page.js fills.
Markup worldSection(const WorldView& view, const Markup& searchForm);

/// An <svg> in which every object is a link to `#object-<id>` and carries its number as data-object: a small
/// image (imageSymbols()) where there is room, else a dot. Areas link to `#area-<id>`. Its attribute data-fit
/// gives the transform from meters to pixels ("scale from-x from-y to-x to-y"; y of the floor grows upwards),
/// and has an empty <g class="way"> for the script. `shapes`: empty for a map without a plan.
Markup worldFigure(const WorldView& view, const PlanShapes& shapes, FigureStyle style);

/// A word that finds an object, for the search form; "" where none has words.
std::string exampleWord(const WorldMap& world);

/// Data of world_page.js: {"from": node, "objects": [{"name", "given", "words": [[label, p]], "probability",
/// "where"}], "areas": [{"id", "name", "given", "room"}]}; label is an index of the vocabulary, p in
/// 1/10,000; "room": WorldArea::roomName. Objects and areas that can be driven to have "cost" (Route::cost),
/// and, where it was driven, "length" and "way" [[x, y]]; objects also "pose" [x, y, yaw], "distance" and
/// "frame" [m, rad].
nlohmann::json worldData(const WorldView& view);

/// A <section> "areas": areas as articles with the id area-<id>, objects as links with the id object-<id>,
/// the most probable first; what is in no area comes last. Empty for a map without areas and objects.
Markup worldList(const WorldView& view);

}  // namespace estancia::report
