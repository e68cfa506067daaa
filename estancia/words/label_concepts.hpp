// Label concepts: familiar words of WordNet that stand for several labels, "dog" for five breeds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// A word that may stand for several labels.
struct LabelConcept {
  /// The label that means just this, else the first word of its synset.
  std::string name;
  /// In (0, 1]: intrinsic information content (Seco, Veale & Hayes 2004), 1 - ln(kinds) / ln(nouns), 0 for
  /// what is above all nouns; 1 where a label means just this.
  double specificity = 1;
  /// Labels that it stands for, ascending; at least two. Familiar words ("desk") stand for themselves.
  std::vector<std::size_t> labels;
  /// `labels`, and all others below it in WordNet's hierarchy.
  std::vector<std::size_t> covered;
};

/// Hypernyms on the level at which people name things (basic level: Rosch et al. 1976; by the frequency of
/// words: Izquierdo, Suárez & Rigau 2007): those that were met at least five times in WordNet's texts, by
/// words that mostly mean this, and with at most a hundred kinds, of animals and plants a thousand. A label
/// that was met three times is on that level itself.
LabelConcepts findLabelConcepts(const WordGraph& graph, const Vocabulary& vocabulary);

/// A word that distinguishes a part of a run from the whole.
struct TellingWord {
  std::string name;
  /// Itself, or all that are below it; ascending.
  std::vector<std::size_t> labels;
  /// Contribution to the relative entropy of the part against the run [nat].
  double evidence = 0;
};

/// Contribution of a label, or of several labels that are taken for one, to the relative entropy of a part
/// against the run: p ln(p / everywhere) (Kullback & Leibler 1951); 0 unless it is likelier than there.
double tellingEvidence(double p, double everywhere);

/// Up to `count` words with evidence, best first by evidence × specificity (1 for a label), ties by fewer
/// labels, then by the first label. A concept, of which the probability is the sum of its labels', is named
/// instead of them where at least two of them have evidence, and it has more than any of them. No word is
/// named beside one that is below or above it, and none twice.
std::vector<TellingWord> tellingWords(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                                      DescriptorView here, DescriptorView run, std::size_t count);

/// A label, or several that one word stands for.
struct FamiliarWord {
  std::string name;
  /// Most probable first.
  std::vector<std::size_t> labels;
  /// The sum of its labels', at most 1.
  float probability = 0;
};

/// The `count` most probable words, best first. A concept stands for its labels where at least two of them
/// are more probable than by chance (1/L, at most 0.01; noise of a hundred breeds is no dog), and the sum of
/// these times its specificity is more than the best of them. Labels of the same name, of several models, are
/// one word. Without concepts, each label is a word of its own. A label is in one word at most.
std::vector<FamiliarWord> familiarWords(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                                        DescriptorView mean, std::size_t count);

/// For people, as where the name of a place is missing: "stove, oven", the two words that distinguish it from
/// the run (tellingWords()), else the most probable one. Without concepts, the most probable label.
std::string familiarTitle(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView here,
                          DescriptorView run);

}  // namespace estancia
