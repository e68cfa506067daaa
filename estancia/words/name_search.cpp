// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/name_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {
namespace {

// Longer words are no name.
constexpr std::size_t maxNameBytes = 100, maxNearNames = 3;

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

/// Whether a meaning of the name is right above one that was asked for.
bool isKindOf(const WordGraph& graph, std::string_view name, const std::vector<std::uint32_t>& asked) {
  const std::vector<std::uint32_t> ofName = graph.lexicon.usualNouns(name);
  return std::ranges::any_of(asked, [&](std::uint32_t synset) {
    return std::ranges::any_of(graph.hypernyms(synset), [&](const auto& above) {
      return above.second == 1 && std::ranges::find(ofName, above.first) != ofName.end();
    });
  });
}

/// The match, where it is the only one.
std::optional<NameMatch> only(const std::vector<std::size_t>& found, std::string reason) {
  if (found.size() != 1) return std::nullopt;
  return NameMatch{found.front(), std::move(reason)};
}

}  // namespace

std::optional<NameMatch> findName(const std::vector<std::string>& names, std::string_view words,
                                  WordGraphSource source) {
  auto found = namesThat(names, [&](const std::string& name) { return name == words; });
  if (!found.empty()) return NameMatch{found.front(), ""};
  if (words.size() > maxNameBytes) return std::nullopt;
  const std::string asked = withoutFunctionWords(words);
  for (const std::string_view form : {words, std::string_view(asked)}) {
    found = namesThat(names, [&](const std::string& name) { return isSameName(name, form); });
    if (!found.empty()) return only(found, "");
  }
  const WordGraph* graph = source == nullptr ? nullptr : source();
  if (graph == nullptr) return std::nullopt;
  const std::string corrected = correctedName(*graph, names, asked);
  const std::string& meant = corrected.empty() ? asked : corrected;
  if (!corrected.empty())
    found = namesThat(names, [&](const std::string& name) { return isSameName(name, corrected); });
  if (found.size() == 1) return NameMatch{found.front(), "by its spelling", true};
  if (!found.empty()) return std::nullopt;
  const std::vector<std::uint32_t> meanings = graph->lexicon.usualNouns(meant);
  found = namesThat(names, [&](const std::string& name) {
    return std::ranges::find_first_of(meanings, graph->lexicon.usualNouns(name)) != meanings.end();
  });
  return only(found, fmt::format("the same as {}", meant));
}

std::optional<NameMatch> findNameOfKind(const std::vector<std::string>& names, std::string_view words,
                                        WordGraphSource source) {
  const WordGraph* graph = source == nullptr || words.size() > maxNameBytes ? nullptr : source();
  if (graph == nullptr) return std::nullopt;
  const std::string asked = withoutFunctionWords(words);
  const std::vector<std::uint32_t> meanings = graph->lexicon.usualNouns(asked);
  return only(namesThat(names, [&](const std::string& name) { return isKindOf(*graph, name, meanings); }),
              fmt::format("{} is a kind of it", asked));
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
