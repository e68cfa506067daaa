// Semantic query of a world: the objects, areas and places that words mean.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/query/ask.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// One object's answer.
struct ObjectAnswer {
  int object = 0;
  /// It was given exactly this name (sameWords()).
  bool isNamed = false;
  /// It was recognized as the known object of this name.
  bool isKnown = false;
  /// It is of the class of this name by its shape (WorldObject::shapeClass()).
  bool isShaped = false;
  /// Σ w_l p(l) over the matched labels, w_l how probably l is meant, at most 1; 1 where it is named so, and
  /// the recognition's confidence, or the probability of the class, where that is larger.
  double probability = 0;
  /// probability / its mean over all objects of the map; 0 where that is 0.
  double lift = 0;
  /// Rank of the best matched label among its words, from 1; 0 where none of them is matched.
  std::size_t rank = 0;
  /// Best matched label; "" where there is none.
  std::string label = {};
  /// Whether it probably is what was asked for: named or recognized so, of that class by its shape, or no
  /// other word fits it better.
  bool isLikely() const { return isNamed || isKnown || isShaped || rank == 1; }
};

/// Meaning of words in a world; labels and rooms as in findMeaning(): an object is never found by a room.
struct WorldMeaning : Meaning {
  /// Areas of this name (areasNamed()); where there are none, those whose name holds the words
  /// (areasNamedPartly()).
  std::vector<int> areas = {};
  /// Whether it is their whole name.
  bool isWholeName = true;
  /// Objects that people gave exactly this name (sameWords()).
  std::vector<int> namedObjects = {};
  /// Objects that were recognized as the known object of this name.
  std::vector<int> knownObjects = {};
  /// Objects that are of the class of this name by their shapes.
  std::vector<int> shapedObjects = {};
  bool empty() const {
    return Meaning::empty() && areas.empty() && namedObjects.empty() && knownObjects.empty() &&
           shapedObjects.empty();
  }
};

/// `source`: as for places alone.
WorldMeaning findMeaning(const WorldMap& world, const std::string& words, WordGraphSource source = nullptr);

struct WorldAnswers : WorldMeaning {
  /// Named objects first, then known objects, then the most probable. Only objects that are likely
  /// (isLikely()), or have a matched label among their five best words, at least as probable as in the mean
  /// of all objects.
  std::vector<ObjectAnswer> objects = {};
  /// Places found by ask(); empty where only names were matched.
  std::vector<PlaceAnswer> places = {};
};

/// At most `places` places and `objects` objects. Throws Error: noAnswer when nothing matches, with near
/// spellings; insufficientData when the map has no places.
WorldAnswers askWorld(const WorldMap& world, const std::string& words, std::size_t places = 10,
                      std::size_t objects = 10, WordGraphSource source = nullptr);

/// Given names, those of known objects and of classes by shape, then words of labels, that are spelled nearly
/// like `words` (findNearSpellings()).
std::vector<std::string> findNearNames(const WorldMap& world, const std::string& words,
                                       std::size_t count = 3);

/// The area of each node, in the order of map.nodes (WorldMap::areaOfNode()), in one pass over the frames.
std::vector<int> areasOfNodes(const WorldMap& world);

}  // namespace estancia
