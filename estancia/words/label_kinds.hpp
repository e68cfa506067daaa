// Label kinds: labels of a vocabulary that are what a word names, "studio couch" for "sofa".
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// Labels that mean what `words` do, or a kind of it, in WordNet's hierarchy; by index, each of probability 1
/// with its reason. Stricter than LabelSearch, for where a wrong label does harm: labels that are related in
/// another way, doubtful labels, and words with no meaning that makes up half of their uses as a noun have
/// none, and spelling is not corrected.
std::vector<LabelMatch> findLabelKinds(const Vocabulary& vocabulary, const WordGraph& graph,
                                       std::string_view words);

}  // namespace estancia
