// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/name_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/words/spelling.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {
namespace {

// Longer words are no name. A meaning that is rarer than this is not what is meant by a word that stands
// alone.
constexpr std::size_t maxNameBytes = 100, maxNearNames = 3;
constexpr float minCommonShare = 0.2F;

/// "living_room" and "Livingroom" → "livingroom".
std::string withoutBlanks(std::string_view name) {
  std::string solid;
  for (const std::string& word : splitText(name)) solid += word;
  return solid;
}

bool isSameName(std::string_view name, std::string_view words) {
  return sameWords(name, words) || (!words.empty() && withoutBlanks(name) == withoutBlanks(words));
}

std::vector<std::size_t> namesThat(const std::vector<std::string>& names, const auto& fits) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (fits(names[i])) found.push_back(i);
  return found;
}

/// The words with each that neither WordNet nor a name has corrected; "" where none is, or one cannot be.
std::string correctedName(const WordGraph& graph, const std::vector<std::string>& names,
                          std::string_view words) {
  std::set<std::string> ofNames;
  for (const std::string& name : names)
    for (std::string& word : splitText(name)) ofNames.insert(std::move(word));
  const std::vector<std::string> preferred(ofNames.begin(), ofNames.end());
  std::string corrected;
  bool changed = false;
  for (const std::string& word : splitText(words)) {
    std::string meant = word;
    if (!graph.lexicon.knows(word) && !ofNames.contains(word)) {
      meant = correctSpelling(graph.lexicon, preferred, word);
      if (meant.empty()) return "";
      changed = true;
    }
    corrected += (corrected.empty() ? "" : " ") + meant;
  }
  return changed ? corrected : "";
}

bool shareMeaning(const WordGraph& graph, std::string_view name, std::string_view words) {
  const std::vector<Sense> ofName = graph.lexicon.senses(lexicalForm(name)),
                           asked = graph.lexicon.senses(lexicalForm(words));
  return std::ranges::any_of(asked, [&](const Sense& sense) {
    return sense.probability >= minCommonShare && graph.pos(sense.synset) == PartOfSpeech::noun &&
           std::ranges::any_of(ofName, [&](const Sense& other) {
             return other.synset == sense.synset && other.probability >= minCommonShare;
           });
  });
}

}  // namespace

std::optional<NameMatch> findName(const std::vector<std::string>& names, std::string_view words,
                                  WordGraphSource source) {
  const auto only = [](const std::vector<std::size_t>& found, std::string reason) {
    return found.size() == 1 ? std::optional(NameMatch{found.front(), std::move(reason)}) : std::nullopt;
  };
  auto found = namesThat(names, [&](const std::string& name) { return name == words; });
  if (!found.empty()) return NameMatch{found.front(), ""};
  if (words.size() > maxNameBytes) return std::nullopt;
  found = namesThat(names, [&](const std::string& name) { return isSameName(name, words); });
  if (!found.empty()) return only(found, "");
  const WordGraph* graph = source == nullptr ? nullptr : source();
  if (graph == nullptr) return std::nullopt;
  const std::string corrected = correctedName(*graph, names, words);
  const std::string& meant = corrected.empty() ? std::string(words) : corrected;
  if (!corrected.empty())
    found = namesThat(names, [&](const std::string& name) { return isSameName(name, corrected); });
  if (!found.empty()) return only(found, "by its spelling");
  found = namesThat(names, [&](const std::string& name) { return shareMeaning(*graph, name, meant); });
  return only(found, fmt::format("the same as {}", meant));
}

std::vector<std::string> findNearNames(const std::vector<std::string>& names, std::string_view words,
                                       WordGraphSource source) {
  if (words.size() > maxNameBytes) return {};
  const std::string asked = withoutBlanks(words);
  std::vector<std::string> near;
  const auto add = [&](const std::string& name) {
    if (near.size() < maxNearNames && std::ranges::find(near, name) == near.end()) near.push_back(name);
  };
  for (std::size_t distance = 0; distance <= asked.size() / 3; ++distance)
    for (const std::string& name : names)
      if (editDistance(withoutBlanks(name), asked) == distance && distance < name.size()) add(name);
  if (asked.empty() || names.empty()) return near;
  for (const LabelMatch& match : findLabelMatches(Vocabulary(names), words, source).labels)
    add(names[match.label]);
  return near;
}

}  // namespace estancia
