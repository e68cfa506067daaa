// World JSON: the output of `--json` of ask and route about objects and areas. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/world_query/route_world.hpp"

namespace estancia {

/// {"id", "name"}; null where there is no such area.
nlohmann::ordered_json areaReference(const WorldMap& world, int area);

/// {"id", "name", "given_name", "predicted_room", "room_probability", "size" [m²], "center": [x, y],
/// "frames"}; values that neither a person nor a classifier gave are null.
nlohmann::ordered_json toJson(const WorldArea& area);

/// {"id", "name", "probability", "given_name", "known", "shape", "position": [x, y, z], "size": [x, y, z],
/// "yaw", "support": "floor", "object", "surface" or "wall", "on": {"id", "name"}, "area": {"id", "name"},
/// "views", "first_seen", "last_seen": {"frame", "number", "drive", "time"}, "image"}: meters, radians,
/// seconds; what is not known is null; image is the frame that shows it best. "known" is the known object
/// that it was recognized as: {"name", "confidence", "position": [x, y, z], "orientation": [x, y, z, w],
/// "frame"}, where its cloud's axes are in the map. "shape" is the answer of a trained object model about its
/// shape: {"class", "probability", "classes": {NAME: p}}.
nlohmann::ordered_json toJson(const WorldObject& object, const WorldMap& world);

/// The form of toJson() for answers of places, whose places have "area", too; before them "areas" and
/// "objects", whose "probability" is that of what was asked, with "lift", "label", "rank", "named",
/// "recognized" and "by_shape".
nlohmann::ordered_json toJson(const std::string& words, const WorldAnswers& answers, const WorldMap& world);

/// The form of toJson() for a route (topology), "driven": {"length", "path": [[x, y]]} [m] or null
/// (DrivenWay), and "areas": [{"id", "name"}] along it where the map has areas. To words: "words", and
/// "goal": "area", "object" or "place", with "area": {"id", "name"}, or "object": toJson() with the
/// probability that was asked for and "pose": {"x", "y", "yaw", "frame", "distance"} [m, rad], or "label" or
/// "room" and "probability". `words`: "" for a node.
nlohmann::ordered_json toJson(const std::string& words, const WorldRoute& found, const WorldMap& world);

/// For people: "recognized as mug (93 %), its axes at (1.00, 2.00, 0.70) m, turned by (0, 0, 0.71, 0.71)"; ""
/// where it is no known object.
std::string knownText(const WorldObject& object);

/// For people: "by its shape chair (61 %)"; "" where no object model was given, or no class is more probable
/// than all others together.
std::string shapeText(const WorldObject& object);

/// For people: "on the floor", "on the dining table"; "" where it is not known.
std::string supportText(const WorldObject& object, const WorldMap& world);

}  // namespace estancia
