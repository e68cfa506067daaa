// Purposes: what things are for, by the verbs in their definitions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estancia/words/word_graph.hpp"

namespace estancia {

/// A noun serves the verb of "… for sitting on", "… to cook food" and the nouns that follow (the telic role
/// of Pustejovsky 1991, The Generative Lexicon), with up to two hypernyms of each: who mows, cuts.
WordPurposes findPurposes(const WordNet& wordNet, const WordGraph& graph);

/// For each of `things`, synsets, how well it serves all of `terms`, in [0, 1]: the mean of how surely each
/// is among its purposes; 0 where none of them is meant as a verb. One value a synset of the graph.
std::vector<float> purposeShares(const WordGraph& graph, std::span<const std::vector<Sense>> terms,
                                 std::span<const std::uint32_t> things);

/// Purpose score of a term by its overlap with those of a synset: the sum of each meaning's smaller share.
float purposeShare(float common);

}  // namespace estancia
