// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_kinds.hpp"

#include <optional>
#include <string>

#include "estancia/words/label_senses.hpp"

namespace estancia {
namespace {

constexpr float usualShareOfNoun = 0.5F;

/// The meaning that half of the word's uses as a noun have.
std::optional<std::uint32_t> usualNoun(const WordGraph& graph, const std::string& word) {
  float all = 0;
  std::optional<Sense> best;
  for (const Sense& sense : graph.lexicon.senses(word)) {
    if (graph.pos(sense.synset) != PartOfSpeech::noun) continue;
    all += sense.probability;
    if (!best || sense.probability > best->probability) best = sense;
  }
  return best && best->probability >= usualShareOfNoun * all ? std::optional(best->synset) : std::nullopt;
}

}  // namespace

std::vector<LabelMatch> findLabelKinds(const Vocabulary& vocabulary, const WordGraph& graph,
                                       std::string_view words) {
  const std::string word = lexicalForm(words);
  const std::optional<std::uint32_t> asked = usualNoun(graph, word);
  if (!asked) return {};
  std::vector<LabelMatch> kinds;
  const std::vector<LabelSense> senses = findLabelSenses(graph, vocabulary);
  for (std::size_t label = 0; label < senses.size(); ++label) {
    if (senses[label].isDoubtful || senses[label].senses.empty()) continue;
    for (const auto& [above, distance] : graph.hypernyms(senses[label].senses.front().synset))
      if (above == *asked) {
        kinds.push_back({label, 1, (distance == 0 ? "the same as " : "a kind of ") + word});
        break;
      }
  }
  return kinds;
}

}  // namespace estancia
