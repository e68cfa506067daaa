// Changes between drives: things that were moved, are gone or are new, and places whose words changed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/world/world_map.hpp"

namespace estancia {

/// A thing whose place was looked at before and after, and is empty in one of them.
struct ObjectChange {
  enum class Kind { moved, gone, appeared };
  Kind kind = Kind::gone;
  /// Where it was and where it is: objects of the map; the same one where it was moved by less than its size.
  std::optional<int> before = {}, now = {};
  /// Its middle there [m].
  cv::Point3d from = {}, to = {};
  /// Share of its points whose place was seen empty.
  double emptiness = 0;
  /// The last frame that shows it where it was, and the first that shows it where it is.
  std::size_t lastBefore = 0, firstNow = 0;
};

/// A place that looks different.
struct PlaceChange {
  int node = 0;
  /// Of the mean words before and since, in units of τ_join; above 1 two places are told apart.
  double distance = 0;
  /// The labels whose probability changed most, and by how much.
  struct Word {
    std::size_t label = 0;
    float before = 0, now = 0;
  };
  std::vector<Word> words = {};
};

struct Changes {
  /// Drives from this one on are "now", those before it "before".
  std::size_t since = 0;
  std::vector<ObjectChange> objects = {};
  std::vector<PlaceChange> places = {};
};

std::string toString(ObjectChange::Kind kind);

/// What drives from `since` on (the last one by default) saw otherwise than those before. A thing is gone
/// where later depth images look through its place, and new where earlier ones did; a thing that is gone
/// and one that is new, of similar words, size and color, is one that was moved. What nobody looked at again
/// is no change. Throws Error as readMap() does, and insufficientData for a map of one drive, or an unknown
/// one.
Changes findChanges(const std::filesystem::path& map, std::optional<std::size_t> since = {});

}  // namespace estancia
