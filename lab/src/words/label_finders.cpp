// SPDX-License-Identifier: Apache-2.0
#include "words/label_finders.hpp"

#include <array>
#include <cmath>

#include "estancia/core/label_words.hpp"

namespace estancia::experiments {

LabelFinders::LabelFinders(const Vocabulary& vocabulary, const WordNet& wordNet)
    : vocabulary_(vocabulary),
      graph_(buildWordGraph(wordNet)),
      senses_(findLabelSenses(graph_, vocabulary)),
      search_(vocabulary, &graph_),
      glosses_(wordNet, vocabulary, senses_) {}

const Choices& LabelFinders::methods() {
  static const Choices methods{
      {"matching", "labels whose names match the words (findLabels()), all others after them"},
      {"gloss TF-IDF", "cosine of the words of definitions, weighted by their rarity"},
      {"hypernyms", "share of the query's meanings that the label is a kind of"},
      {"walk", "log lift of random walks in the word graph"},
      {"search", "what users get: exact names, then the probabilities of LabelSearch"}};
  return methods;
}

std::vector<double> LabelFinders::score(std::size_t method, const std::string& query) const {
  using Score = std::vector<double> (LabelFinders::*)(const std::string&) const;
  constexpr std::array<Score, 5> scores{&LabelFinders::byMatching, &LabelFinders::byGlosses,
                                        &LabelFinders::byHypernyms, &LabelFinders::byWalk,
                                        &LabelFinders::bySearch};
  return (this->*scores.at(method))(query);
}

/// Meanings of each known term: of all words together where WordNet has them so.
std::vector<std::vector<Sense>> LabelFinders::termsOf(const std::string& query) const {
  std::vector<std::vector<Sense>> terms{graph_.lexicon.senses(query)};
  if (!terms.front().empty()) return terms;
  terms.clear();
  for (const std::string& term : graph_.lexicon.terms(query))
    if (std::vector<Sense> senses = graph_.lexicon.senses(term); !senses.empty())
      terms.push_back(std::move(senses));
  return terms;
}

std::vector<double> LabelFinders::byMatching(const std::string& query) const {
  std::vector<double> scores(vocabulary_.size(), 0);
  for (const std::size_t label : findLabels(vocabulary_, query)) scores[label] = 1;
  return scores;
}

std::vector<double> LabelFinders::byGlosses(const std::string& query) const {
  return glosses_.score(query, termsOf(query));
}

std::vector<double> LabelFinders::byHypernyms(const std::string& query) const {
  std::vector<double> scores(vocabulary_.size(), 0);
  const std::vector<std::vector<Sense>> terms = termsOf(query);
  for (std::size_t label = 0; label < scores.size(); ++label) {
    if (senses_[label].senses.empty()) continue;
    for (const auto& [above, distance] : graph_.hypernyms(senses_[label].senses.front().synset))
      for (const std::vector<Sense>& senses : terms)
        for (const Sense& sense : senses)
          if (sense.synset == above)
            scores[label] += static_cast<double>(sense.probability) / static_cast<double>(terms.size());
  }
  return scores;
}

std::vector<double> LabelFinders::byWalk(const std::string& query) const {
  std::vector<double> scores(vocabulary_.size(), 0);
  for (const std::vector<Sense>& senses : termsOf(query)) {
    const std::vector<float> visits = graph_.walk(senses);
    for (std::size_t label = 0; label < scores.size(); ++label) {
      double ratio = std::exp(WordGraph::minLift);
      for (const Sense& sense : senses_[label].senses)
        ratio += static_cast<double>(sense.probability) * std::exp(graph_.lift(visits, sense.synset));
      scores[label] += std::log(ratio);
    }
  }
  return scores;
}

std::vector<double> LabelFinders::bySearch(const std::string& query) const {
  std::vector<double> scores = search_.probabilities(query);
  // Above all that would not be shown.
  for (const LabelMatch& match : search_.search(query, vocabulary_.size()).labels)
    scores[match.label] = 1 + match.probability;
  return scores;
}

}  // namespace estancia::experiments
