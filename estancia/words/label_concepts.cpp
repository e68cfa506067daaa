// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_concepts.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
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
// Kinds of a concept: "furniture" (199) and "container" (749) are unspecific, "dog" (190), "bird" (872) not.
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
