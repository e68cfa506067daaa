// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/naming.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// How many words make a name: the thesis shows three (Fig. 5.6).
constexpr std::size_t wordsOfName = 3;
/// Zones that still have the same name after so many words are alike to people.
constexpr std::size_t maxWordsOfName = 12;

/// The first `count` different words: words with evidence, then likely ones.
std::vector<std::string> distinctiveWords(const Vocabulary& vocabulary, DescriptorView zone,
                                          DescriptorView run, const LabelConcepts& concepts,
                                          std::size_t count) {
  std::vector<std::string> words;
  std::set<std::size_t> told;
  for (TellingWord& word : tellingWords(vocabulary, concepts, zone, run, count)) {
    told.insert(word.labels.begin(), word.labels.end());
    words.push_back(std::move(word.name));
  }
  for (const std::size_t label : distinctiveLabels(zone, run, 2 * count)) {
    std::string word = shortLabel(vocabulary[label]);
    if (words.size() < count && !told.contains(label) && std::ranges::find(words, word) == words.end())
      words.push_back(std::move(word));
  }
  return words;
}

}  // namespace

std::vector<std::size_t> distinctiveLabels(DescriptorView zone, DescriptorView run, std::size_t count) {
  std::vector<float> contribution(zone.size());
  for (std::size_t i = 0; i < zone.size(); ++i)
    contribution[i] =
        static_cast<float>(tellingEvidence(static_cast<double>(zone[i]), static_cast<double>(run[i])));
  std::vector<std::size_t> labels = bestLabels(contribution, count);
  std::erase_if(labels, [&](std::size_t label) { return contribution[label] <= 0; });
  for (const std::size_t label : bestLabels(zone, count)) {
    const bool known = std::find(labels.begin(), labels.end(), label) != labels.end();
    if (labels.size() < count && !known && zone[label] > 0) labels.push_back(label);
  }
  return labels;
}

std::vector<std::string> nameZones(const Vocabulary& vocabulary, const std::vector<std::vector<float>>& means,
                                   DescriptorView run, const LabelConcepts& concepts) {
  std::vector<std::string> names;
  std::set<std::set<std::string>> taken;  // whatever their order
  for (const std::vector<float>& mean : means) {
    const std::vector<std::string> words = distinctiveWords(vocabulary, mean, run, concepts, maxWordsOfName);
    auto end = words.begin() + static_cast<std::ptrdiff_t>(std::min(wordsOfName, words.size()));
    while (end != words.end() && taken.contains({words.begin(), end})) ++end;
    taken.emplace(words.begin(), end);
    names.push_back(words.empty() ? "no words" : fmt::format("{}", fmt::join(words.begin(), end, ", ")));
  }
  return names;
}

}  // namespace estancia
