// Label relevance: how probably a person who asks for a word accepts a label, by how related the two are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/words/lexicon.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// Relations of a label to words.
struct LabelEvidence {
  /// Lift of a walk from the words (WordGraph::lift()), through usedLift().
  double lift = 0;
  /// Lift of the most related label of the same model.
  double bestLift = 0;
  /// kindShare() of a single word; of a room's name also usualShare of that of a furnishing. In [0, 1].
  double kind = 0;
  /// How well it, or what it is a kind of, serves the words as a purpose (purposeShares()). In [0, 1].
  double purpose = 0;
};

/// In [0, 1]; grows with lift, kind and purpose, and falls with bestLift.
double labelRelevance(const LabelEvidence& evidence);

/// The lift from which on a label that is the best one, and no kind of what is asked for, has a relevance of
/// at least `probability`, in (0, 1), if it has no such purpose either.
double liftFor(double probability);

/// Lift, limited to the range that carries information; minUsedLift for a label that WordNet lacks.
double usedLift(double lift);
constexpr double minUsedLift = -5;

/// How much a label is a kind of what a word means, by their hypernym: less for rare senses and far ones.
double kindShare(float senseProbability, int distance);

/// The largest over all pairs of `senses`, a word's, and `hypernyms`, a label's with their distances.
double kindShare(std::span<const Sense> senses, std::span<const std::pair<std::uint32_t, int>> hypernyms);

/// A kind of what serves a purpose serves it: the largest of `shares` of the hypernyms, less for far ones.
double inheritedShare(std::span<const float> shares,
                      std::span<const std::pair<std::uint32_t, int>> hypernyms);

/// How much of a share is left for a hypernym of this distance, in (0, 1].
double hypernymDecay(int distance);

/// Things usual in a room are weaker answers to its name than kinds of what was asked for.
constexpr double usualShare = 0.8;

/// The meanings of a room's furnishing: those of the word that are things.
std::vector<Sense> furnishingSenses(const WordGraph& graph, const std::string& word);

}  // namespace estancia
