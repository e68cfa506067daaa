// Changes between drives: things that were moved, are gone or are new, and places whose words changed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// Something whose place was looked at before and after, and is empty in one of them.
struct ObjectChange {
  enum class Kind { moved, gone, appeared };
  Kind kind = Kind::gone;
  /// The object of the map that it is, or was a part of, where it was and where it is; nothing where that is
  /// none. Both are the same where a thing was pushed aside or turned.
  std::optional<int> before = {}, now = {};
  /// Whether it is most of that object.
  bool isWhole = false;
  /// Its middle there [m], on the map's axes.
  cv::Point3d from = {}, to = {};
  /// Its surface that was seen empty there [m²].
  double area = 0;
  /// The last frame that shows it where it was, and the first that shows it where it is.
  std::size_t lastBefore = 0, firstNow = 0;
};

/// A place that looks different.
struct PlaceChange {
  int node = 0;
  /// Between the mean images before and since, in units of τ_join: at 1 and above they would be two places.
  double distance = 0;
  /// The labels whose probability changed most, and by how much.
  struct Word {
    std::string label = {};
    float before = 0, now = 0;
  };
  std::vector<Word> words = {};
};

struct Changes {
  /// Drives from this one on are "now", those before it "before".
  std::size_t since = 0;
  std::vector<ObjectChange> objects = {};
  std::vector<PlaceChange> places = {};
  /// The whole map that the numbers above are of, as of the same moment.
  std::shared_ptr<const WorldMap> world = {};
};

std::string toString(ObjectChange::Kind kind);

/// Differences between drives from `since` on (the last one by default) and those before. The surface of a
/// thing is gone where later depth images look through its place, twice at least, and new where earlier ones
/// did; pieces side by side are one change, from 160 cm² on. A gone and a new piece of one object, or of one
/// size with similar words, are one moved object. Surfaces that were not looked at again are no changes.
/// Needs depth and poses; places need neither. Throws Error as readMap() does, insufficientData for a map of
/// one drive, and unknownName for a drive that it does not have.
Changes findChanges(const std::filesystem::path& map, std::optional<std::size_t> since = {});

/// For people: "mug", "part of wardrobe", "something". `world`: Changes::world.
std::string nameOf(const ObjectChange& change, const WorldMap& world);

/// {"since": drive, "objects": [{"kind": "moved", "gone" or "new", "name" or null, "whole", "object_before",
/// "object_now", "area_m2", "from", "from_area", "last_seen", "to", "to_area", "first_seen"}], "places":
/// [{"node", "distance", "words": [{"label", "before", "now"}]}]}: [x, y, z] in the map [m], areas as
/// {"id", "name"} or null, frames by their names; a thing that is gone has no "to", a new one no "from".
nlohmann::ordered_json toJson(const Changes& changes);

}  // namespace estancia
