// SPDX-License-Identifier: Apache-2.0
#include "words/gloss_similarity.hpp"

#include <array>
#include <cmath>
#include <set>

namespace estancia::experiments {
namespace {

/// Endings of nouns and verbs and what stands there in the base form, as in Morphy (morphy(7WN)).
constexpr std::array<std::pair<std::string_view, std::string_view>, 9> detachments{{{"ies", "y"},
                                                                                    {"es", ""},
                                                                                    {"es", "e"},
                                                                                    {"s", ""},
                                                                                    {"ed", ""},
                                                                                    {"ed", "e"},
                                                                                    {"ing", ""},
                                                                                    {"ing", "e"},
                                                                                    {"men", "man"}}};
constexpr std::size_t shortestStem = 3;

}  // namespace

GlossSimilarity::GlossSimilarity(const WordNet& wordNet, const Vocabulary& vocabulary,
                                 const std::vector<LabelSense>& senses)
    : wordNet_(wordNet) {
  for (const WordNetEntry& entry : wordNet.entries) {
    const std::string word = lexicalForm(entry.word);
    forms_.emplace(word, word);
  }
  for (const WordNet::IrregularForm& irregular : wordNet.irregularForms)
    forms_.insert_or_assign(lexicalForm(irregular.form), lexicalForm(irregular.word));
  for (const WordNetSynset& synset : wordNet.synsets) {
    const std::vector<std::string> words = wordsOf(synset.gloss);
    for (const std::string& word : std::set(words.begin(), words.end())) ++glossesWith_[word];
  }
  for (std::size_t label = 0; label < vocabulary.size(); ++label) {
    std::string text = vocabulary[label];
    if (!senses[label].senses.empty()) {
      const WordNetSynset& synset = wordNet.synsets[senses[label].senses.front().synset];
      for (const std::string& word : synset.words) text += ' ' + word;
      text += ' ' + synset.gloss;
    }
    labels_.push_back(bagOf(text));
  }
}

std::string GlossSimilarity::baseForm(const std::string& word) const {
  const auto known = forms_.find(word);
  if (known != forms_.end() && known->second != word) return known->second;
  // Before the word itself: "washing" is in WordNet, too, and means "wash".
  for (const auto& [ending, base] : detachments) {
    if (!word.ends_with(ending) || word.size() < ending.size() + shortestStem || word.ends_with("ss"))
      continue;
    const auto stem = forms_.find(word.substr(0, word.size() - ending.size()) + std::string(base));
    if (stem != forms_.end()) return stem->second;
  }
  return word;
}

std::vector<std::string> GlossSimilarity::wordsOf(std::string_view text) const {
  std::vector<std::string> words;
  for (const std::string& word : splitText(text))
    if (!isFunctionWord(word)) words.push_back(baseForm(word));
  return words;
}

GlossSimilarity::Bag GlossSimilarity::bagOf(const std::string& text) const {
  Bag bag;
  for (const std::string& word : wordsOf(text)) bag[word] += 1;
  double squares = 0;
  for (auto& [word, weight] : bag) {
    // A word that no gloss has is as rare as one that a single gloss has.
    const auto found = glossesWith_.find(word);
    const double glosses = found == glossesWith_.end() ? 1 : static_cast<double>(found->second);
    weight *= std::log(static_cast<double>(wordNet_.synsets.size() + 1) / glosses);
    squares += weight * weight;
  }
  for (auto& [word, weight] : bag) weight /= std::sqrt(squares);
  return bag;
}

std::vector<double> GlossSimilarity::score(std::string_view query,
                                           const std::vector<std::vector<Sense>>& terms) const {
  std::string text(query);
  for (const std::vector<Sense>& senses : terms)
    if (!senses.empty()) text += ' ' + wordNet_.synsets[senses.front().synset].gloss;
  const Bag asked = bagOf(text);
  std::vector<double> cosines;
  for (const Bag& label : labels_) {
    double cosine = 0;
    for (const auto& [word, weight] : label)
      if (const auto same = asked.find(word); same != asked.end()) cosine += weight * same->second;
    cosines.push_back(cosine);
  }
  return cosines;
}

}  // namespace estancia::experiments
