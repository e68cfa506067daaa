// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_concepts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "estancia/core/label_words.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_senses.hpp"

namespace estancia {
namespace {

// How often a word was tagged with its meaning in WordNet's texts.
constexpr std::uint32_t familiarConcept = 5, familiarLabel = 3;
// Kinds of a concept: "furniture" (199) and "container" (749) are unspecific, "dog" (190) and "bird" (872)
// specific.
constexpr std::size_t maxKinds = 100, maxKindsOfLife = 1000;
constexpr float minShareOfSense = 0.5F;

/// Reads concepts of one vocabulary from the word graph.
class ConceptFinder {
 public:
  explicit ConceptFinder(const WordGraph& graph) : graph_(graph) {}

  LabelConcepts find(const Vocabulary& vocabulary) {
    const std::vector<LabelSense> senses = findLabelSenses(graph_, vocabulary);
    LabelConcepts found;
    std::map<std::uint32_t, LabelConcept> concepts;
    for (std::size_t label = 0; label < senses.size(); ++label) {
      const std::optional<std::uint32_t> meaning = clearMeaning(senses[label]);
      if (!meaning) continue;
      const bool isFamiliar = count(*meaning) >= familiarLabel;
      for (const auto& [synset, distance] : graph_.hypernyms(*meaning)) {
        if (!isConcept(synset)) continue;
        LabelConcept& above = concepts[synset];
        above.covered.push_back(label);
        if (distance == 0 && above.name.empty()) above.name = shortLabel(vocabulary[label]);
        if (distance == 0 || !isFamiliar) above.labels.push_back(label);
      }
    }
    for (auto& [synset, above] : concepts) {
      if (above.labels.size() < 2) continue;
      if (above.name.empty()) {
        above.name = graph_.name(synset);
        above.specificity = specificity(synset);
      }
      found.push_back(std::move(above));
    }
    return found;
  }

 private:
  std::optional<std::uint32_t> clearMeaning(const LabelSense& label) const {
    if (label.isDoubtful || label.senses.empty() || label.senses.front().probability < minShareOfSense)
      return std::nullopt;
    const std::uint32_t synset = label.senses.front().synset;
    return graph_.pos(synset) == PartOfSpeech::noun ? std::optional(synset) : std::nullopt;
  }

  std::uint32_t count(std::uint32_t synset) const {
    return graph_.lexicon.tagCount(graph_.name(synset), synset);
  }

  bool isConcept(std::uint32_t synset) {
    const auto [known, isNew] = isConcept_.try_emplace(synset, false);
    if (isNew)
      known->second = count(synset) >= familiarConcept && isUsualMeaning(synset) &&
                      graph_.category(synset) != WordCategory::tops && kinds(synset) <= kindLimit(synset);
    return known->second;
  }

  /// Whether the synset is the usual meaning of its name as a noun: "piece" rarely means cloth.
  bool isUsualMeaning(std::uint32_t synset) const {
    std::uint32_t sum = 0;
    for (const Sense& sense : graph_.lexicon.senses(graph_.name(synset)))
      if (graph_.pos(sense.synset) == PartOfSpeech::noun)
        sum += graph_.lexicon.tagCount(graph_.name(synset), sense.synset);
    return 2 * count(synset) >= sum;
  }

  std::size_t kindLimit(std::uint32_t synset) const {
    const WordCategory category = graph_.category(synset);
    return category == WordCategory::animal || category == WordCategory::plant ? maxKindsOfLife : maxKinds;
  }

  /// Itself, and all synsets below it.
  std::size_t kinds(std::uint32_t synset) {
    const auto [known, isNew] = kinds_.try_emplace(synset, 0);
    if (!isNew) return known->second;
    std::vector<std::uint32_t> found{synset};
    std::set<std::uint32_t> seen{synset};
    for (std::size_t next = 0; next < found.size(); ++next)
      for (std::uint32_t e = graph_.edgeStarts[found[next]]; e < graph_.edgeStarts[found[next] + 1]; ++e)
        if (static_cast<WordLink>(graph_.edgeLinks[e]) == WordLink::moreGeneral &&
            seen.insert(graph_.edgeTargets[e]).second)
          found.push_back(graph_.edgeTargets[e]);
    return known->second = found.size();
  }

  double specificity(std::uint32_t synset) {
    const double nouns = std::max(2.0, static_cast<double>(graph_.lexicon.firstSynset[1]));
    return 1 - std::log(static_cast<double>(kinds(synset))) / std::log(nouns);
  }

  const WordGraph& graph_;
  std::map<std::uint32_t, bool> isConcept_;
  std::map<std::uint32_t, std::size_t> kinds_;
};

/// Whether two ascending lists have an item in common.
bool meet(const std::vector<std::size_t>& one, const std::vector<std::size_t>& other) {
  auto a = one.begin();
  auto b = other.begin();
  while (a != one.end() && b != other.end())
    if (*a == *b)
      return true;
    else
      *a < *b ? ++a : ++b;
  return false;
}

struct Candidate {
  TellingWord word;
  double score = 0;
};

bool goesBefore(const Candidate& a, const Candidate& b) {
  const std::vector<std::size_t>&one = a.word.labels, &other = b.word.labels;
  if (a.score != b.score) return a.score > b.score;
  return one.size() != other.size() ? one.size() < other.size() : one < other;
}

/// The concept's evidence, or nothing if one of its labels has more.
std::optional<Candidate> candidateOf(const LabelConcept& named, DescriptorView here, DescriptorView run) {
  double p = 0, everywhere = 0, best = 0;
  std::size_t telling = 0;
  for (const std::size_t label : named.labels) {
    const auto own = static_cast<double>(here[label]), ownEverywhere = static_cast<double>(run[label]);
    p += own;
    everywhere += ownEverywhere;
    const double evidence = tellingEvidence(own, ownEverywhere);
    telling += evidence > 0;
    best = std::max(best, evidence);
  }
  const double evidence = tellingEvidence(p, everywhere), score = evidence * named.specificity;
  if (telling < 2 || score <= best) return std::nullopt;
  return Candidate{{named.name, named.covered, evidence}, score};
}

}  // namespace

LabelConcepts findLabelConcepts(const WordGraph& graph, const Vocabulary& vocabulary) {
  return ConceptFinder(graph).find(vocabulary);
}

std::shared_ptr<const LabelConcepts> installedConcepts(const Vocabulary& vocabulary,
                                                       const NamingOptions& options) {
  static const auto none = std::make_shared<const LabelConcepts>();
  if (options.words == NamingOptions::Words::raw) return none;
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) return none;
  static std::mutex mutex;
  static std::string last;
  static std::shared_ptr<const LabelConcepts> concepts;
  const std::scoped_lock lock(mutex);
  if (!concepts || last != vocabulary.digest()) {
    concepts = std::make_shared<const LabelConcepts>(findLabelConcepts(*graph, vocabulary));
    last = vocabulary.digest();
  }
  return concepts;
}

double tellingEvidence(double p, double everywhere) {
  constexpr double rounding = 1.001;  // a part that is the run
  return everywhere > 0 && p > rounding * everywhere ? p * std::log(p / everywhere) : 0;
}

std::vector<TellingWord> tellingWords(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                                      DescriptorView here, DescriptorView run, std::size_t count) {
  std::vector<Candidate> candidates;
  for (const LabelConcept& named : concepts)
    if (auto candidate = candidateOf(named, here, run)) candidates.push_back(std::move(*candidate));
  for (std::size_t label = 0; label < here.size(); ++label)
    if (const double evidence =
            tellingEvidence(static_cast<double>(here[label]), static_cast<double>(run[label]));
        evidence > 0)
      candidates.push_back({{shortLabel(vocabulary[label]), {label}, evidence}, evidence});
  std::sort(candidates.begin(), candidates.end(), goesBefore);
  // A concept goes before each of its labels, which are left out unless it is.
  std::vector<TellingWord> words;
  for (Candidate& candidate : candidates) {
    if (words.size() == count) break;
    const bool isTold = std::ranges::any_of(words, [&](const TellingWord& other) {
      return other.name == candidate.word.name || meet(other.labels, candidate.word.labels);
    });
    if (!isTold) words.push_back(std::move(candidate.word));
  }
  return words;
}

}  // namespace estancia
