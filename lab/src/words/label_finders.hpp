// Label finders: ways to rank a vocabulary's labels by how well they answer a query in words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/word_graph.hpp"
#include "estancia/words/wordnet.hpp"
#include "words/gloss_similarity.hpp"

namespace estancia::experiments {

class LabelFinders {
 public:
  /// Keeps references to both. Takes seconds: WordNet is joined to a graph.
  LabelFinders(const Vocabulary& vocabulary, const WordNet& wordNet);
  LabelFinders(const LabelFinders&) = delete;
  LabelFinders& operator=(const LabelFinders&) = delete;

  /// Their names, each with what it does; search, which users get, is the last.
  static const Choices& methods();

  /// A score of each label, the largest first in the ranking. `method` is an index in methods(). Only
  /// search corrects spelling.
  std::vector<double> score(std::size_t method, const std::string& query) const;

  const LabelSearch& search() const { return search_; }

 private:
  std::vector<std::vector<Sense>> termsOf(const std::string& query) const;
  std::vector<double> byMatching(const std::string& query) const;
  std::vector<double> byGlosses(const std::string& query) const;
  std::vector<double> byHypernyms(const std::string& query) const;
  std::vector<double> byWalk(const std::string& query) const;
  std::vector<double> bySearch(const std::string& query) const;

  const Vocabulary& vocabulary_;
  WordGraph graph_;
  std::vector<LabelSense> senses_;
  LabelSearch search_;
  GlossSimilarity glosses_;
};

}  // namespace estancia::experiments
