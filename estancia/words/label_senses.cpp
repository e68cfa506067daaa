// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_senses.hpp"

#include <algorithm>
#include <map>

#include "estancia/core/label_words.hpp"
#include "estancia/words/imagenet_synsets.hpp"

namespace estancia {
namespace {

/// Of a list in ImageNet's order, so many labels must be named by their synset.
constexpr double minNamed = 0.95;
/// A second meaning this near to the first leaves doubt.
constexpr float doubtfulShare = 0.6F;
constexpr std::size_t maxSenses = 3;
/// Of a compound that WordNet does not know, its last word's share: "sports ball" is a ball.
constexpr float headShare = 0.7F;

/// How well a meaning of a noun suits a label: what a camera sees.
float visibility(WordCategory category) {
  switch (category) {
    case WordCategory::artifact:
    case WordCategory::food:
    case WordCategory::animal:
      return 1;
    case WordCategory::plant:
    case WordCategory::object:
    case WordCategory::location:
      return 0.7F;
    case WordCategory::tops:
    case WordCategory::person:
    case WordCategory::substance:
      return 0.5F;
    case WordCategory::body:
    case WordCategory::phenomenon:
      return 0.3F;
    case WordCategory::group:
    case WordCategory::communication:
      return 0.1F;
    default:
      return 0.05F;
  }
}

std::vector<std::string> synonymsOf(const std::string& label) {
  std::vector<std::string> synonyms;
  std::size_t from = 0;
  while (from <= label.size()) {
    const std::size_t comma = std::min(label.find(',', from), label.size());
    std::string synonym;
    for (const std::string& word : splitText(shortLabel(label.substr(from, comma - from))))
      synonym += (synonym.empty() ? "" : " ") + word;
    if (!synonym.empty()) synonyms.push_back(std::move(synonym));
    from = comma + 1;
  }
  return synonyms;
}

std::vector<Sense> normalized(const std::map<std::uint32_t, float>& weights) {
  std::vector<Sense> senses;
  for (const auto& [synset, weight] : weights) senses.push_back({synset, weight});
  std::sort(senses.begin(), senses.end(), [](const Sense& a, const Sense& b) {
    return a.probability != b.probability ? a.probability > b.probability : a.synset < b.synset;
  });
  if (senses.size() > maxSenses) senses.resize(maxSenses);
  float sum = 0;
  for (const Sense& sense : senses) sum += sense.probability;
  for (Sense& sense : senses) sense.probability /= sum;
  return senses;
}

void addVisible(const WordGraph& graph, const std::string& word, float share,
                std::map<std::uint32_t, float>& weights) {
  float sum = 0;
  std::vector<Sense> visible;
  for (Sense sense : graph.lexicon.senses(word)) {
    if (graph.pos(sense.synset) != PartOfSpeech::noun) continue;
    sense.probability *= visibility(graph.category(sense.synset));
    visible.push_back(sense);
    sum += sense.probability;
  }
  for (const Sense& sense : visible) weights[sense.synset] += share * sense.probability / sum;
}

LabelSense lookUp(const WordGraph& graph, const std::string& label) {
  LabelSense found;
  std::map<std::uint32_t, float> weights;
  for (const std::string& synonym : synonymsOf(label)) addVisible(graph, synonym, 1, weights);
  if (weights.empty()) {
    const std::vector<std::string> words = graph.lexicon.terms(label);
    for (std::size_t i = 0; i < words.size(); ++i)
      addVisible(graph, words[i],
                 i + 1 == words.size() ? headShare : (1 - headShare) / static_cast<float>(i + 1), weights);
    found.isDoubtful = true;
  }
  found.senses = normalized(weights);
  found.isDoubtful |= !found.senses.empty() && found.senses.front().probability < doubtfulShare;
  return found;
}

/// Synsets of ImageNet's classes; empty when the graph is of a WordNet in which they are others.
std::vector<std::uint32_t> imageNetIndices(const WordGraph& graph) {
  const auto nouns = graph.offsets.begin() + graph.lexicon.firstSynset[0];
  const auto end = graph.offsets.begin() + graph.lexicon.firstSynset[1];
  std::vector<std::uint32_t> indices;
  for (const std::uint32_t offset : imageNetSynsets) {
    const auto at = std::lower_bound(nouns, end, offset);
    if (at == end || *at != offset) return {};
    indices.push_back(static_cast<std::uint32_t>(at - graph.offsets.begin()));
  }
  return indices;
}

/// Senses of labels in ImageNet's order, maybe after one of background; none unless nearly all are named by
/// theirs.
std::vector<LabelSense> inImageNetOrder(const WordGraph& graph, std::span<const std::string> labels) {
  const std::vector<std::uint32_t> indices = imageNetIndices(graph);
  if (indices.empty() || labels.size() < indices.size() || labels.size() > indices.size() + 1) return {};
  const std::size_t skipped = labels.size() - indices.size();
  std::vector<LabelSense> senses(labels.size());
  std::size_t named = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    senses[i + skipped].senses = {{indices[i], 1}};
    const std::vector<std::string> synonyms = synonymsOf(labels[i + skipped]);
    const std::vector<Sense> meant =
        synonyms.empty() ? std::vector<Sense>() : graph.lexicon.senses(synonyms.front());
    named += std::any_of(meant.begin(), meant.end(),
                         [&](const Sense& sense) { return sense.synset == indices[i]; });
  }
  return static_cast<double>(named) < minNamed * static_cast<double>(indices.size())
             ? std::vector<LabelSense>()
             : senses;
}

}  // namespace

std::vector<LabelSense> findLabelSenses(const WordGraph& graph, const Vocabulary& vocabulary) {
  std::vector<LabelSense> senses;
  std::size_t from = 0;
  for (const LabelPart& part : vocabulary.layout().parts) {
    const std::span<const std::string> labels = std::span(vocabulary.labels()).subspan(from, part.size);
    std::vector<LabelSense> found = inImageNetOrder(graph, labels);
    if (found.empty())
      for (const std::string& label : labels) found.push_back(lookUp(graph, label));
    senses.insert(senses.end(), found.begin(), found.end());
    from += part.size;
  }
  return senses;
}

}  // namespace estancia
