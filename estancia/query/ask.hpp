// Semantic query: places ranked by the probability of a word (thesis 4.6), or of a predicted room.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/map_file/map.hpp"
#include "estancia/words/label_choice.hpp"

namespace estancia {

/// One place's answer.
struct PlaceAnswer {
  int node = 0;
  /// Σ w_l p̄_N(l) over the matched labels, w_l how probably l is meant, or Σ of the matched rooms; at most 1.
  double probability = 0;
  /// probability / its mean over all frames of the map: how much more than elsewhere.
  double lift = 0;
  /// Rank of the node's best match among all its labels, or its rooms, from 1.
  std::size_t rank = 0;
  /// Index of that label.
  std::size_t label = 0;
  /// Or that room; "" where labels were matched.
  std::string room = {};
  /// rank ≤ 5.
  bool inTop5 = false;
  /// Whether the place is likely to hold it: among its 5 best labels, or its best room.
  bool isLikely() const { return room.empty() ? inTop5 : rank == 1; }
};

/// Matches of words in a map: labels or, where a classifier has predicted rooms, rooms; never both.
struct Meaning {
  /// Indices of the vocabulary.
  std::vector<std::size_t> labels;
  std::vector<std::string> rooms;
  /// How probably each of `labels` is meant, and why; in their order.
  std::vector<LabelMatch> matches = {};
  /// The words that were looked for, where some were misspelled; else "".
  std::string corrected = {};
  bool empty() const { return labels.empty() && rooms.empty(); }
};

/// A room of exactly that name (sameWords()), which the classifier was trained on; else, unless labels hold
/// the words, rooms that findLabels() would find by their names, or that the words mean otherwise
/// (findName(), findNameOfKind()); else labels that the words mean (findLabelMatches()). Empty when nothing
/// matches. `source`: installedWordGraph to understand words that no label has; nullptr: labels are found by
/// their names alone.
Meaning findMeaning(const TopologicalMap& map, const std::string& words, WordGraphSource source = nullptr);

struct Answers : Meaning {
  /// Most probable first.
  std::vector<PlaceAnswer> places = {};
};

/// The `count` places that most probably hold what is meant. They are ordered by probability; for one label
/// ordering by lift would be the same, since the mean it divides by is the map's. Throws Error
/// (insufficientData) when the map has no places.
std::vector<PlaceAnswer> placesThatHold(const Meaning& meaning, const TopologicalMap& map,
                                        std::size_t count = 10);

/// What `words` mean (findMeaning()), and the places that hold it. Throws Error: noAnswer when nothing
/// matches, with near spellings; insufficientData when the map has no places.
Answers ask(const TopologicalMap& map, const std::string& words, std::size_t count = 10,
            WordGraphSource source = nullptr);

}  // namespace estancia
