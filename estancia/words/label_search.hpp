// Label search: which labels of a vocabulary a person means by words of her own, and why.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_choice.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {

/// Result of LabelSearch::search(); the graph is not used if labels have that name.
LabelMatches findLabelMatches(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source);

/// Finds labels by relatedness in WordNet. A query's words are looked up as they are, as plurals and other
/// forms, and by near spellings; of several words each counts the same (the mean of their log lifts).
class LabelSearch {
 public:
  /// Without a graph only findLabels() is left. Keeps references to both.
  LabelSearch(const Vocabulary& vocabulary, const WordGraph* graph);

  /// labelsNamed(), of the words or of their corrected spelling, where there are some, and of the models
  /// without any only likely() labels that are a kind of what is asked for; else at most `count` likely()
  /// labels, from `minProbability` on (of several words shareOfSeveral of it), and those of findLabels().
  LabelMatches search(std::string_view words, std::size_t count = everyLabel,
                      double minProbability = defaultMinProbability) const;

  /// The probability of each label; 0 where nothing of `words` is known.
  std::vector<double> probabilities(std::string_view words) const;

  /// The relevance, but 0 for a label that is less probable than `defaultMinProbability` (of several words
  /// shareOfSeveral of it), or no kind of what is asked for and below nearTheBest of the best one.
  std::vector<double> likely(std::string_view words) const;

  static constexpr std::size_t everyLabel = std::numeric_limits<std::size_t>::max();
  /// Where accepted and missed labels balance on the even queries of lab/experiments/words/queries.csv.
  static constexpr double defaultMinProbability = 0.3;
  /// Labels below this share of the best one's are dropped. Best of 0.3 to 0.6 there (F1 0.58; 0.57 without).
  static constexpr double nearTheBest = 0.5;
  /// Share of `defaultMinProbability` where several words carry meaning: few labels are related to all of
  /// them, so the mean of their lifts is low, and the best labels by it are mostly right all the same. The
  /// best of 0.2 to 1 on the same queries (F1 0.616; 0.610 without).
  static constexpr double shareOfSeveral = 0.4;

 private:
  struct Term {
    std::string word;
    std::vector<Sense> senses;
    /// Visit counts of a walk from the senses.
    std::vector<float> visits;
  };
  struct Query {
    std::vector<Term> terms;
    /// The room that the words name, and its furnishings, without walks.
    const CommonRoom* room = nullptr;
    std::vector<Term> furnishings = {};
    /// purposeShares() of the terms.
    std::vector<float> purposes = {};
    std::string corrected = {};
  };
  Query parse(std::string_view words) const;
  std::vector<double> probabilities(const Query& query) const;
  std::vector<double> likely(const Query& query, double minProbability) const;
  double liftOf(const Term& term, std::size_t label) const;
  double kindOf(const Query& query, std::size_t label) const;
  /// purposeShares() of each term alone.
  using TermPurposes = std::vector<std::vector<float>>;
  std::string servedVerb(const Query& query, std::size_t label, const TermPurposes& ofTerms) const;
  std::string reasonFor(const Query& query, std::size_t label, const TermPurposes& ofTerms) const;

  const Vocabulary& vocabulary_;
  const WordGraph* graph_;
  std::vector<LabelSense> senses_;
  /// Hypernyms of each label's first sense.
  std::vector<std::vector<std::pair<std::uint32_t, int>>> hypernyms_;
  /// All of these hypernyms.
  std::vector<std::uint32_t> allHypernyms_;
  /// Words of labels, sorted: misspelled words mostly stand for one of them.
  std::vector<std::string> labelWords_;
};

/// Labels that mean what `words` do, or a kind of it, in WordNet's hierarchy; by index, each of probability 1
/// with its reason. Stricter than LabelSearch, for where a wrong label does harm: nothing for other
/// relations, doubtful labels, misspellings, and words with no meaning of half of their uses as a noun.
std::vector<LabelMatch> findLabelKinds(const Vocabulary& vocabulary, const WordGraph& graph,
                                       std::string_view words);

}  // namespace estancia
