// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/page_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "estancia/core/label_words.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/word_associations.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia::report {
namespace {

/// Number of words that a card or the list shows for each place and object.
constexpr std::size_t bestWordsShown = 10;
/// Two digits number as many.
constexpr std::size_t maxPackedLabels = 1296;
/// Threshold for words that are not frequent, raised until all fit.
constexpr std::array rarePercents{50, 60, 70, 80, 90, 101};

/// The labels that matter here, the most probable ones where there are too many.
std::vector<char> labelsThatMatter(const MapPage& page) {
  const std::vector<std::string>& names = page.map.vocabulary.labels();
  std::vector<float> largest(names.size(), 0);
  for (const Node& node : page.map.nodes)
    for (const std::size_t label : bestLabels(node.mean, bestWordsShown))
      largest[label] = std::max(largest[label], node.mean[label]);
  if (page.world != nullptr) {
    std::unordered_map<std::string_view, std::size_t> numbers;
    for (std::size_t label = 0; label < names.size(); ++label) numbers.emplace(names[label], label);
    for (const WorldObject& object : page.world->world.objects)
      for (std::size_t i = 0; i < std::min(bestWordsShown, object.words.size()); ++i)
        if (const auto number = numbers.find(object.words[i].label); number != numbers.end())
          largest[number->second] = std::max(largest[number->second], object.words[i].probability);
  }
  std::vector<std::size_t> order;
  for (std::size_t label = 0; label < largest.size(); ++label)
    if (largest[label] > 0) order.push_back(label);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t label) { return largest[label]; });
  if (order.size() > maxPackedLabels) order.resize(maxPackedLabels);
  std::vector<char> matter(names.size(), 0);
  for (const std::size_t label : order) matter[label] = 1;
  return matter;
}

/// For each word of the labels' names, and two of them together, the labels; nothing where they are too many.
std::unordered_map<std::string, std::unordered_set<std::uint32_t>> labelsByWord(
    const Vocabulary& vocabulary) {
  std::unordered_map<std::string, std::unordered_set<std::uint32_t>> labels;
  if (vocabulary.size() > maxPackedLabels) return labels;
  for (std::uint32_t label = 0; label < vocabulary.size(); ++label) {
    const std::vector<std::string> words = splitText(vocabulary[label]);
    for (std::size_t i = 0; i < words.size(); ++i) {
      labels[words[i]].insert(label);
      if (i > 0) labels[words[i - 1] + ' ' + words[i]].insert(label);
    }
  }
  return labels;
}

/// Words that are known and not listed: they are not to be taken for misspelled.
std::vector<std::string_view> otherWords(const MapPage& page, const std::vector<WordAssociation>& listed) {
  std::vector<std::string_view> others;
  for (std::size_t i = 0; page.lexicon != nullptr && i < page.lexicon->size(); ++i) {
    const std::string_view word = page.lexicon->word(i);
    if (isTypedWord(word) && word.find(' ') == std::string_view::npos &&
        !std::ranges::binary_search(listed, word, {},
                                    [](const auto& one) -> std::string_view { return one.word; }))
      others.push_back(word);
  }
  return others;
}

}  // namespace

nlohmann::json pageWords(const MapPage& page) {
  if (page.words == nullptr || page.words->empty()) return nullptr;
  const std::vector<char> matter = labelsThatMatter(page);
  const auto named = labelsByWord(page.map.vocabulary);
  const auto isListed = [&](const std::string& word, std::uint32_t label) {
    if (matter.at(label) != 0) return true;
    const auto labels = named.find(word);
    return labels != named.end() && labels->second.contains(label);
  };
  PackedAssociations packed;
  std::vector<WordAssociation> selected;
  for (const int rare : rarePercents) {
    AssociationLimits limits;
    limits.minRarePercent = rare;
    selected = selectAssociations(*page.words, isListed, limits);
    packed = packAssociations(selected);
    if (packed.text.size() <= page.wordBytes) break;
  }
  return {{"labels", packed.labels},
          {"text", packed.text},
          {"known", packWordFilter(otherWords(page, selected))},
          {"grammar", fmt::format("{}", fmt::join(functionWords(), " "))}};
}

}  // namespace estancia::report
