// Gloss similarity: TF-IDF vectors of WordNet's definitions and their cosines, a plain baseline.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/wordnet.hpp"

namespace estancia::experiments {

/// Compares bags of words: those of a label are its line, and gloss (definition and examples) and synonyms of
/// its first meaning; those of a query its own, and the glosses of the most probable meaning of each of its
/// terms. Function words are left out, inflected forms count as their base form. A word counts its frequency
/// in the bag times log(N / n), where n of all N glosses have it (G. Salton & C. Buckley 1988: Term-weighting
/// approaches in automatic text retrieval).
class GlossSimilarity {
 public:
  /// Keeps a reference to WordNet. `senses`: one a label.
  GlossSimilarity(const WordNet& wordNet, const Vocabulary& vocabulary,
                  const std::vector<LabelSense>& senses);

  /// The cosine of each label's bag and the query's, in [0, 1]; `terms`: the meanings of its terms.
  std::vector<double> score(std::string_view query, const std::vector<std::vector<Sense>>& terms) const;

 private:
  /// Word → weight; of unit length, or empty.
  using Bag = std::unordered_map<std::string, double>;
  std::string baseForm(const std::string& word) const;
  std::vector<std::string> wordsOf(std::string_view text) const;
  Bag bagOf(const std::string& text) const;

  const WordNet& wordNet_;
  /// Inflected form → base form; base forms stand for themselves.
  std::unordered_map<std::string, std::string> forms_;
  /// In how many glosses a word is.
  std::unordered_map<std::string, std::size_t> glossesWith_;
  std::vector<Bag> labels_;
};

}  // namespace estancia::experiments
