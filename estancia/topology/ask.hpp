// "Where is the umbrella?": places ranked by a word (thesis 4.6: which nodes hold "refrigerator" among their
// five best).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/topology/map.hpp"

namespace estancia {

/// One place's answer.
struct PlaceAnswer {
  int node = 0;
  double probability = 0;  ///< Σ p̄_N(l) over the matched labels, at most 1
  double lift = 0;        ///< probability / its mean over all images of the map: how much more than elsewhere
  std::size_t rank = 0;   ///< place of the node's best matched label among all its labels, from 1
  std::size_t label = 0;  ///< that label
  bool amongBest5 = false;  ///< rank ≤ 5
};

struct Answers {
  std::vector<std::size_t> labels;  ///< what the words were taken for: indices of the vocabulary
  std::vector<PlaceAnswer> places;  ///< most probable first
};

/// The `count` places that most probably hold `words` (see findLabels()). Places are ordered by probability;
/// for one label ordering by lift would be the same, since the mean it divides by is the map's. Throws Error
/// when no label matches, naming near spellings, and when the map has no places.
Answers ask(const TopologicalMap& map, const std::string& words, std::size_t count = 10);

}  // namespace estancia
