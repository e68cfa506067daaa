// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_senses.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// Min share of labels that must be named by their synset in a list in ImageNet's order.
constexpr double minNamed = 0.95;
/// A second meaning this near to the first leaves doubt.
constexpr float doubtfulShare = 0.6F;
constexpr std::size_t maxSenses = 3;
/// Weight of the last word of a compound that WordNet lacks: "sports ball" is a ball.
constexpr float headShare = 0.7F;
/// Minimum number of labels that determine the meaning of each other one.
constexpr std::size_t minContext = 10;

/// How well a meaning of a noun suits a label: what a camera sees.
float visibility(WordCategory category) {
  using enum WordCategory;
  if (category == artifact || category == food || category == animal) return 1;
  if (category == plant || category == object || category == location) return 0.7F;
  if (category == tops) return 0.5F;
  if (category == substance) return 0.3F;
  if (category == body || category == person) return 0.2F;  // "diner", "toaster": mostly the thing
  return category == group || category == communication ? 0.1F : 0.05F;
}

std::vector<std::string> synonymsOf(const std::string& label) {
  std::vector<std::string> synonyms;
  std::size_t from = 0;
  while (from <= label.size()) {
    const std::size_t comma = std::min(label.find(',', from), label.size());
    const std::vector<std::string> words = splitText(shortLabel(label.substr(from, comma - from)));
    if (!words.empty()) synonyms.push_back(fmt::format("{}", fmt::join(words, " ")));
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

/// Looks labels up by their words.
class LabelReader {
 public:
  explicit LabelReader(const WordGraph& graph) : graph_(graph) {}

  std::vector<LabelSense> read(std::span<const std::string> labels) {
    std::vector<LabelSense> found = readAlone(labels);
    if (labels.size() < minContext) return found;
    std::vector<Sense> all;
    for (const LabelSense& label : found)
      for (const Sense& sense : label.senses)
        all.push_back({sense.synset, sense.probability / static_cast<float>(labels.size())});
    context_ = graph_.walk(all);
    return readAlone(labels);
  }

 private:
  std::vector<LabelSense> readAlone(std::span<const std::string> labels) const {
    std::vector<LabelSense> found;
    for (const std::string& label : labels) found.push_back(lookUp(label));
    return found;
  }

  LabelSense lookUp(const std::string& label) const {
    std::map<std::uint32_t, float> weights;
    for (const std::string& synonym : synonymsOf(label)) addVisible(synonym, 1, weights);
    if (!weights.empty()) return sensesBy(weights, false);
    // "church/indoor", "stadium/baseball": a church, a stadium.
    if (const std::size_t slash = label.find('/'); slash != std::string::npos)
      if (LabelSense kind = lookUp(label.substr(0, slash)); !kind.senses.empty()) return kind;
    std::vector<std::string> words;
    for (const std::string& term : graph_.lexicon.terms(label))
      if (isNoun(term))
        words.push_back(term);
      else  // "cell phone" is a verb, each word a noun
        for (const std::string& word : splitText(term)) words.push_back(word);
    for (std::size_t i = 0; i < words.size(); ++i)
      addVisible(words[i], i + 1 == words.size() ? headShare : (1 - headShare) / static_cast<float>(i + 1),
                 weights);
    return sensesBy(weights, true);
  }

  static LabelSense sensesBy(const std::map<std::uint32_t, float>& weights, bool isDoubtful) {
    LabelSense found{normalized(weights), isDoubtful};
    found.isDoubtful |= !found.senses.empty() && found.senses.front().probability < doubtfulShare;
    return found;
  }

  bool isNoun(const std::string& word) const {
    const std::vector<Sense> senses = graph_.lexicon.senses(word);
    return std::any_of(senses.begin(), senses.end(),
                       [&](const Sense& sense) { return graph_.pos(sense.synset) == PartOfSpeech::noun; });
  }

  /// Shares `share` among the meanings of a noun.
  void addVisible(const std::string& word, float share, std::map<std::uint32_t, float>& weights) const {
    float sum = 0;
    std::vector<Sense> visible;
    for (Sense sense : graph_.lexicon.senses(word)) {
      if (graph_.pos(sense.synset) != PartOfSpeech::noun) continue;
      sense.probability *= visibility(graph_.category(sense.synset));
      if (!context_.empty())
        sense.probability *= static_cast<float>(std::exp(graph_.lift(context_, sense.synset)));
      visible.push_back(sense);
      sum += sense.probability;
    }
    for (const Sense& sense : visible) weights[sense.synset] += share * sense.probability / sum;
  }

  const WordGraph& graph_;
  /// Visits of a walk from what all labels may mean; empty: not known yet. A meaning near to those of the
  /// others is likelier: a "tv" among a sofa and a vase is a set (Agirre & Soroa 2009).
  std::vector<float> context_;
};

/// Synsets of ImageNet's classes; empty when the graph is of a WordNet in which they are others.
std::vector<std::uint32_t> imageNetIndices(const WordGraph& graph) {
  const auto nouns = graph.offsets.begin() + graph.lexicon.firstSynset[0];
  const auto end = graph.offsets.begin() + graph.lexicon.firstSynset[1];
  std::vector<std::uint32_t> indices;
  for (const std::uint32_t offset : imageNetSynsets()) {
    const auto at = std::lower_bound(nouns, end, offset);
    if (at == end || *at != offset) return {};
    indices.push_back(static_cast<std::uint32_t>(at - graph.offsets.begin()));
  }
  return indices;
}

/// Senses of labels in ImageNet's order, maybe after a background; none unless nearly all have its names.
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
    if (found.empty()) found = LabelReader(graph).read(labels);
    senses.insert(senses.end(), found.begin(), found.end());
    from += part.size;
  }
  return senses;
}

const std::vector<std::uint32_t>& imageNetSynsets() {
  static const std::vector<std::uint32_t> synsets = [] {
    std::vector<std::uint32_t> offsets;
    std::istringstream text(imageNetSynsetList);
    for (std::uint32_t offset = 0; text >> offset;) offsets.push_back(offset);
    return offsets;
  }();
  return synsets;
}

}  // namespace estancia
