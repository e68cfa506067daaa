// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/familiar_words.hpp"

#include <algorithm>
#include <functional>
#include <map>

#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// Max probability of noise in a small vocabulary; below chance.
constexpr float maxNoise = 0.01F;

struct ScoredWord {
  FamiliarWord word;
  double score = 0;
};

/// The first synonym; the whole label where that is blank.
std::string wordOf(const std::string& label) {
  std::string word = shortLabel(label);
  const auto last = word.find_last_not_of(' ');
  if (last == std::string::npos) return label;
  word.resize(last + 1);
  return word;
}

/// The concept with those of its labels that are there; a score of 0 where it does not stand for them.
ScoredWord scored(const LabelConcept& named, DescriptorView mean) {
  ScoredWord found{{named.name, {}, 0}};
  const float noise = std::min(maxNoise, 1 / static_cast<float>(mean.size()));
  float best = 0;
  for (const std::size_t label : named.labels) {
    if (label >= mean.size() || mean[label] <= noise) continue;
    found.word.labels.push_back(label);
    found.word.probability += mean[label];
    best = std::max(best, mean[label]);
  }
  const double score = static_cast<double>(found.word.probability) * named.specificity;
  if (found.word.labels.size() > 1 && score > static_cast<double>(best)) found.score = score;
  return found;
}

/// The words of concepts, the most informative first, and none for a label that has one already.
std::vector<FamiliarWord> conceptWords(const LabelConcepts& concepts, DescriptorView mean,
                                       std::vector<char>& told) {
  std::vector<ScoredWord> candidates;
  for (const LabelConcept& named : concepts)
    if (ScoredWord candidate = scored(named, mean); candidate.score > 0)
      candidates.push_back(std::move(candidate));
  std::ranges::stable_sort(candidates, std::ranges::greater(), &ScoredWord::score);
  std::vector<FamiliarWord> words;
  for (ScoredWord& candidate : candidates) {
    const std::vector<std::size_t>& labels = candidate.word.labels;
    if (std::ranges::any_of(labels, [&](std::size_t label) { return told[label] != 0; })) continue;
    for (const std::size_t label : labels) told[label] = 1;
    words.push_back(std::move(candidate.word));
  }
  return words;
}

}  // namespace

std::vector<FamiliarWord> familiarWords(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                                        DescriptorView mean, std::size_t count) {
  std::vector<FamiliarWord> words;
  if (concepts.empty()) {
    for (const std::size_t label : bestLabels(mean, count))
      words.push_back({wordOf(vocabulary[label]), {label}, mean[label]});
    return words;
  }
  std::vector<char> told(mean.size(), 0);
  words = conceptWords(concepts, mean, told);
  std::map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < words.size(); ++i) numbers.emplace(words[i].name, i);
  for (std::size_t label = 0; label < mean.size(); ++label) {
    if (told[label] != 0) continue;
    const std::string name = wordOf(vocabulary[label]);
    const auto [known, isNew] = numbers.try_emplace(name, words.size());
    if (isNew) words.push_back({name, {}, 0});
    words[known->second].labels.push_back(label);
    words[known->second].probability += mean[label];
  }
  for (FamiliarWord& word : words) {
    word.probability = std::min(word.probability, 1.0F);
    std::ranges::stable_sort(word.labels, [mean](std::size_t a, std::size_t b) { return mean[a] > mean[b]; });
  }
  std::ranges::stable_sort(words, [](const FamiliarWord& a, const FamiliarWord& b) {
    return a.probability != b.probability ? a.probability > b.probability : a.labels < b.labels;
  });
  if (words.size() > count) words.resize(count);
  return words;
}

std::string familiarTitle(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView here,
                          DescriptorView run) {
  constexpr std::size_t wordsOfTitle = 2;
  std::string title;
  if (!concepts.empty() && here.size() == vocabulary.size() && run.size() == here.size())
    for (const TellingWord& word : tellingWords(vocabulary, concepts, here, run, wordsOfTitle))
      title += (title.empty() ? "" : ", ") + word.name;
  if (!title.empty()) return title;
  const std::vector<FamiliarWord> words = familiarWords(vocabulary, concepts, here, 1);
  return words.empty() ? "" : words.front().name;
}

}  // namespace estancia
