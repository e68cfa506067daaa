// Room words: the evidence of labels for rooms that are known by their names alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// Rooms and places that are tried if none are listed: homes, offices, shops, outdoors.
const std::vector<std::string>& commonRooms();

/// A room that many buildings have, and what makes it one (definitions seldom name all); outdoors nothing.
struct CommonRoom {
  std::string name;
  std::vector<std::string> furnishings;
};

/// The one of commonRooms() that the words name, but for case, hyphens, underscores and plurals; or nullptr.
const CommonRoom* findCommonRoom(std::string_view words);

/// The common room of that name, else the only one of commonRooms() that has a usual meaning in common with
/// the words: "sitting room" is a living room.
const CommonRoom* findCommonRoom(const WordGraph& graph, std::string_view words);

/// Rooms that the user lists: without blanks around the names, each once (sameWords()). Throws Error
/// (invalidOption) for a name without a letter, or with control characters.
std::vector<std::string> listedRooms(const std::vector<std::string>& names);

/// A row a room, a value ≥ 0 a label: the square of how far its log lift (WordGraph::lift()) from the room's
/// name lies above the mean of all artifacts of WordNet, in their standard deviations, less two. To a name of
/// commonRooms() half of the mean of the same for that room's furnishings is added ("living room": sofa,
/// television …). Names of several words: the mean of their log lifts, as in LabelSearch. Underscores count
/// as blanks. Throws Error (unknownName) for a room whose name WordNet does not know.
std::vector<std::vector<float>> roomLabelWeights(const WordGraph& graph, const Vocabulary& vocabulary,
                                                 const std::vector<std::string>& rooms);

/// Whether WordNet knows a word of each of the names, so that roomLabelWeights() has them all.
bool knowsRooms(const WordGraph& graph, const std::vector<std::string>& rooms);

}  // namespace estancia
