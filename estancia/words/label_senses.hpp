// Label senses: which of WordNet's meanings the labels of a vocabulary have.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// Meaning of one label.
struct LabelSense {
  /// Meanings by their probability, which add up to 1; empty: WordNet does not know the label.
  std::vector<Sense> senses;
  /// Whether another meaning is nearly as probable, or only a word of the label is known.
  bool isDoubtful = false;
};

/// One a label. ImageNet's thousand classes are recognized by their order, as they are or after one class of
/// background, which means nothing; those of other models are looked up by their synonyms. There, things that
/// can be seen go before ideas, and meanings near to those of the other labels before others; of "A/B" A
/// counts alone, and where a label is unknown its words stand for it, the last one most. Each part of a
/// vocabulary of several models is looked at alone.
std::vector<LabelSense> findLabelSenses(const WordGraph& graph, const Vocabulary& vocabulary);

/// Byte offsets of nouns in WordNet 3.0, rising: 1440764 is tench, n01440764 (Russakovsky et al. 2015:
/// ImageNet Large Scale Visual Recognition Challenge, Int. J. of Computer Vision 115).
const std::vector<std::uint32_t>& imageNetSynsets();

/// imagenet_synsets.txt, compiled in.
extern const std::string imageNetSynsetList;

}  // namespace estancia
