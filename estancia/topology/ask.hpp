// "Where is the umbrella?": places ranked by a word (thesis 4.6: which nodes hold "refrigerator" among their
// five best), or by a room that a classifier has named.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/topology/map.hpp"

namespace estancia {

/// One place's answer.
struct PlaceAnswer {
  int node = 0;
  double probability = 0;  ///< Σ p̄_N(l) over the matched labels, or Σ of the matched rooms; at most 1
  double lift = 0;        ///< probability / its mean over all images of the map: how much more than elsewhere
  std::size_t rank = 0;   ///< place of the node's best match among all its labels, or its rooms, from 1
  std::size_t label = 0;  ///< that label
  std::string room;       ///< or that room; "" where the words were taken for labels
  bool inTop5 = false;    ///< rank ≤ 5
};

/// What words are taken for in a map: labels or, where a classifier has named rooms, rooms; never both.
struct Meaning {
  std::vector<std::size_t> labels;  ///< indices of the vocabulary
  std::vector<std::string> rooms;
  bool empty() const { return labels.empty() && rooms.empty(); }
};

/// A room of that very name (sameWords()): a classifier was taught it. Else labels (findLabels()), else rooms
/// that findLabels() would find by their names. Empty when nothing matches.
Meaning findMeaning(const TopologicalMap& map, const std::string& words);

struct Answers : Meaning {
  std::vector<PlaceAnswer> places;  ///< most probable first
};

/// The `count` places that most probably hold `words` (see findMeaning()). Places are ordered by probability;
/// for one label ordering by lift would be the same, since the mean it divides by is the map's. Throws Error
/// when nothing matches, naming near spellings, and when the map has no places.
Answers ask(const TopologicalMap& map, const std::string& words, std::size_t count = 10);

}  // namespace estancia
