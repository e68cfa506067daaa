// World export: a map with its areas and objects for other programs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/query/export.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// The formats of exportWorld(): those of exportMap(), and
///  * rooms: {"format": "estancia-rooms", "version": 1, "rooms": [toJson(WorldArea) with "outline": [[x, y]],
///    "neighbors": [ids], "places": [{"id", "words": [{"label", "p"}], "position", "frames", "objects":
///    [toJson(WorldObject) with "words"]}]], "elsewhere": {"places"}}: areas → places → objects [m, rad];
///    elsewhere is what is in no area. An object whose area has no place is at the place that shows it best.
///  * spark-dsg: the JSON of Spark-DSG (see sparkDsgJson()).
Choices worldFormats();

/// Whether the format lists which frames each place has: "frame_ranges".
bool listsFrames(const std::string& format);

/// Like exportMap(), with areas and objects: in nav2 the places' metadata have "area", "area_id" and
/// "objects" (names), and areas (Polygon) and objects (MultiPoint, since the loader of Nav2 takes each Point
/// for a node) are features of their own, which that loader skips; in graphml areas and objects are nodes
/// ("kind"), held by edges ("relation": "in", "at", "on"). Without areas and objects the same bytes as
/// exportMap(). Throws Error as exportMap(); unsupportedFile for rooms of a map without areas.
std::string exportWorld(const WorldMap& world, const std::string& format, const ExportOptions& options = {});

}  // namespace estancia
