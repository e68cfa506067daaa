// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_associations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <set>
#include <utility>

#include "estancia/core/base64.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/words/label_relevance.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/purposes.hpp"
#include "estancia/words/room_words.hpp"

namespace estancia {
namespace {

constexpr std::size_t together = WordGraph::together;
constexpr std::size_t maxWordsOfOne = 2, longestTypedWord = 24;

/// A word that may be asked for.
struct TypedWord {
  std::size_t entry = 0;  ///< entry of the lexicon
  std::vector<Sense> senses;
};

std::vector<TypedWord> typedWords(const WordGraph& graph) {
  const Lexicon& lexicon = graph.lexicon;
  std::vector<TypedWord> words;
  for (std::size_t i = 0; i < lexicon.size(); ++i) {
    const std::string_view word = lexicon.word(i);
    if (isTypedWord(word)) words.push_back({i, lexicon.senses(word)});
  }
  return words;
}

/// A word and a label that may turn out to be meant.
struct Pair {
  std::uint32_t word = 0, label = 0;
  float lift = 0, kind = 0, purpose = 0;
};

/// A label that a word probably means.
struct Likely {
  std::uint32_t label = 0;
  double probability = 0;
  bool isKind = false;
};

/// Labels of LabelSearch::likely(), most probable first.
std::vector<WordAssociation::Meant> meantOf(const std::vector<Likely>& likely) {
  double best = 0;
  for (const Likely& one : likely) best = std::max(best, one.probability);
  std::vector<WordAssociation::Meant> meant;
  for (const Likely& one : likely)
    if (one.isKind || one.probability >= LabelSearch::nearTheBest * best)
      meant.push_back({one.label, static_cast<std::uint8_t>(std::lround(100 * one.probability))});
  std::ranges::stable_sort(meant, std::greater(), &WordAssociation::Meant::percent);
  return meant;
}

/// A batch of `together` labels.
struct Batch {
  std::vector<Pair> pairs;
  /// For each word, the largest exp(lift) of these labels; empty where none has a sense.
  std::vector<float> best;
};

/// Computes which words lead to which labels. Life cycle: the constructor inverts the word graph, then run()
/// once. Invariant: `wordsOf_` and `served_` have one entry a synset, and no batch has labels of two models.
class Associating {
 public:
  Associating(const WordGraph& graph, const Vocabulary& vocabulary)
      : graph_(graph),
        labels_(findLabelSenses(graph, vocabulary)),
        words_(typedWords(graph)),
        minRatio_(std::exp(liftFor(LabelSearch::defaultMinProbability))) {
    std::size_t from = 0;
    for (const LabelPart& part : vocabulary.layout().parts) {  // no batch is of two models
      for (std::size_t label = from; label < from + part.size; label += together)
        batches_.push_back({label, std::min(label + together, from + part.size), parts_});
      from += part.size;
      ++parts_;
    }
    wordsOf_.resize(graph.size());
    served_.resize(graph.size());
    for (std::uint32_t w = 0; w < words_.size(); ++w)
      for (const Sense& sense : words_[w].senses) wordsOf_[sense.synset].push_back({w, sense.probability, 1});
    findServed();
    addFurnishings();
  }

  std::vector<WordAssociation> run(int threads, Progress& progress) {
    progress.begin("words", batches_.size());
    std::vector<std::vector<Pair>> pairs(batches_.size());
    std::vector<std::vector<float>> best(parts_);  // a number for each word and batch would be gigabytes
    std::mutex mutex;
    inParallel(batches_.size(), threads, progress, "stopped while relating words to labels",
               [&](std::size_t i) {
                 Batch batch = associate(batches_[i]);
                 pairs[i] = std::move(batch.pairs);
                 const std::lock_guard lock(mutex);
                 std::vector<float>& ofPart = best[batches_[i].part];
                 ofPart.resize(std::max(ofPart.size(), batch.best.size()), 0);
                 std::ranges::transform(batch.best, ofPart, ofPart.begin(), std::ranges::max);
               });
    progress.end();
    // The threshold depends on the best label of the same model, which is known now.
    std::vector<std::vector<Likely>> likely(words_.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
      for (const Pair& pair : pairs[i]) {
        const double bestLift = usedLift(std::log(static_cast<double>(best[batches_[i].part][pair.word])));
        const double probability = labelRelevance({pair.lift, bestLift, pair.kind, pair.purpose});
        if (probability >= LabelSearch::defaultMinProbability)
          likely[pair.word].push_back({pair.label, probability, pair.kind > 0});
      }
    return worthNaming(likely);
  }

 private:
  struct Naming {
    std::uint32_t word = 0;
    float probability = 0;
    double share = 1;
  };
  struct Served {
    std::uint32_t word = 0;
    float share = 0;
  };
  struct Labels {
    std::size_t from = 0, to = 0, part = 0;
  };

  Batch associate(const Labels& labels) const {
    Batch batch;
    std::vector<std::vector<Sense>> starts;
    for (std::size_t label = labels.from; label < labels.to; ++label) starts.push_back(labels_[label].senses);
    if (std::all_of(starts.begin(), starts.end(), [](const auto& senses) { return senses.empty(); }))
      return batch;
    const std::vector<float> visits = graph_.walkTogether(starts);
    batch.best.assign(words_.size(), 0);
    std::array<std::vector<float>, together> kinds, purposes;
    for (std::size_t lane = 0; lane < starts.size(); ++lane)
      if (!starts[lane].empty()) {
        kinds[lane] = kindsOf(starts[lane].front().synset);
        purposes[lane] = purposesOf(starts[lane].front().synset);
      }
    for (std::size_t w = 0; w < words_.size(); ++w) {
      const std::array<double, together> ratios = ratiosOf(words_[w], visits);
      batch.best[w] = static_cast<float>(*std::max_element(ratios.begin(), ratios.end()));
      for (std::size_t lane = 0; lane < starts.size(); ++lane) {
        if (starts[lane].empty()) continue;
        const float kind = kinds[lane][w], purpose = purposes[lane][w];
        if (kind == 0 && purpose == 0 && ratios[lane] < minRatio_)
          continue;  // nearly all: a logarithm would be most of the work
        batch.pairs.push_back({static_cast<std::uint32_t>(w), static_cast<std::uint32_t>(labels.from + lane),
                               static_cast<float>(usedLift(std::log(ratios[lane]))), kind, purpose});
      }
    }
    return batch;
  }

  /// How much more often each label's walker meets the word than one who walks for ever.
  std::array<double, together> ratiosOf(const TypedWord& word, const std::vector<float>& visits) const {
    std::array<double, together> ratios;
    ratios.fill(std::exp(WordGraph::minLift));
    for (const Sense& sense : word.senses) {
      if (graph_.degrees[sense.synset] <= 0) continue;
      const double factor = static_cast<double>(sense.probability) * graph_.degreeSum /
                            static_cast<double>(graph_.degrees[sense.synset]);
      for (std::size_t lane = 0; lane < together; ++lane)
        ratios[lane] += factor * static_cast<double>(visits[sense.synset * together + lane]);
    }
    return ratios;
  }

  /// For each word LabelEvidence::kind of a label that means `synset`.
  std::vector<float> kindsOf(std::uint32_t synset) const {
    std::vector<float> kinds(words_.size(), 0);
    for (const auto& [above, distance] : graph_.hypernyms(synset))
      for (const auto& [word, probability, share] : wordsOf_[above])
        kinds[word] = std::max(kinds[word], static_cast<float>(share * kindShare(probability, distance)));
    return kinds;
  }

  /// For each word LabelEvidence::purpose of a label that means `synset`.
  std::vector<float> purposesOf(std::uint32_t synset) const {
    std::vector<float> purposes(words_.size(), 0);
    for (const auto& [above, distance] : graph_.hypernyms(synset))
      for (const auto& [word, share] : served_[above])
        purposes[word] = std::max(purposes[word], static_cast<float>(hypernymDecay(distance) * share));
    return purposes;
  }

  /// Sets what the furnishings of rooms are usual in, for all words that mean a room.
  void addFurnishings() {
    std::set<std::uint32_t> rooms;  // looking every word up would take long
    for (const std::string& room : commonRooms())
      for (const std::uint32_t noun : graph_.lexicon.usualNouns(room)) rooms.insert(noun);
    const auto isRoom = [&](const Sense& sense) { return rooms.contains(sense.synset); };
    for (std::uint32_t w = 0; w < words_.size(); ++w) {
      if (std::ranges::none_of(words_[w].senses, isRoom)) continue;
      const CommonRoom* room = findCommonRoom(graph_, graph_.lexicon.word(words_[w].entry));
      if (room == nullptr) continue;
      for (const std::string& furnishing : room->furnishings)
        for (const Sense& sense : furnishingSenses(graph_, furnishing))
          wordsOf_[sense.synset].push_back({w, sense.probability, usualShare});
    }
  }

  /// Sets served_, as purposeShares() would for each word alone.
  void findServed() {
    const WordPurposes& all = graph_.purposes;
    std::vector<float> common(words_.size(), 0);
    std::vector<bool> isVerb(words_.size(), false);
    for (std::size_t s = 0; s < graph_.size(); ++s) {
      std::vector<std::uint32_t> touched;
      for (std::uint32_t p = all.starts[s]; p < all.starts[s + 1]; ++p)
        for (const auto& [word, probability, share] : wordsOf_[all.synsets[p]]) {
          if (common[word] == 0) touched.push_back(word);
          common[word] += std::min(probability, all.shares[p]);
          if (graph_.pos(all.synsets[p]) == PartOfSpeech::verb) isVerb[word] = true;
        }
      for (const std::uint32_t word : touched) {
        if (isVerb[word]) served_[s].push_back({word, purposeShare(common[word])});
        common[word] = 0;
        isVerb[word] = false;
      }
    }
  }

  std::vector<WordAssociation> worthNaming(const std::vector<std::vector<Likely>>& likely) const {
    std::vector<WordAssociation> associations;
    for (std::size_t w = 0; w < words_.size(); ++w) {
      const bool isFrequent = graph_.lexicon.frequencies[words_[w].entry] > 0;
      if (!isFrequent && likely[w].empty()) continue;
      associations.push_back(
          {std::string(graph_.lexicon.word(words_[w].entry)), isFrequent, meantOf(likely[w])});
    }
    return associations;
  }

  const WordGraph& graph_;
  const std::vector<LabelSense> labels_;
  const std::vector<TypedWord> words_;
  std::vector<Labels> batches_;
  std::size_t parts_ = 0;
  /// exp() of the least lift that is enough without being a kind of what is asked for.
  const double minRatio_;
  /// For each synset the words that are its purpose.
  std::vector<std::vector<Served>> served_;
  /// For each synset the words that may mean it, or a room that it is usual in.
  std::vector<std::vector<Naming>> wordsOf_;
};

constexpr std::string_view packedDigits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";

std::string twoDigits(std::size_t value) {
  return {packedDigits[value / packedDigits.size()], packedDigits[value % packedDigits.size()]};
}

constexpr std::uint64_t bitsSet = 7;

/// FNV-1a (Fowler, Noll, Vo) from a basis of one's choice.
std::uint32_t hashOf(std::string_view word, std::uint32_t basis) {
  for (const char c : word) basis = (basis ^ static_cast<unsigned char>(c)) * 16777619U;
  return basis;
}

}  // namespace

bool isTypedWord(std::string_view word) {
  const auto isLetter = [](char c) { return c >= 'a' && c <= 'z'; };
  return word.size() > 1 && word.size() <= longestTypedWord && isLetter(word.front()) &&
         isLetter(word.back()) && !isFunctionWord(word) &&
         std::count(word.begin(), word.end(), ' ') < static_cast<std::ptrdiff_t>(maxWordsOfOne) &&
         std::all_of(word.begin(), word.end(), [&](char c) { return isLetter(c) || c == ' ' || c == '\''; });
}

std::vector<WordAssociation> associateWords(const WordGraph& graph, const Vocabulary& vocabulary, int threads,
                                            Progress& progress) {
  return Associating(graph, vocabulary).run(threads, progress);
}

std::vector<WordAssociation> selectAssociations(
    const std::vector<WordAssociation>& associations,
    const std::function<bool(const std::string&, std::uint32_t)>& isListed, const AssociationLimits& limits) {
  constexpr std::size_t rareShare = 4;
  std::vector<WordAssociation> selected;
  for (const WordAssociation& all : associations) {
    WordAssociation some{all.word, all.isFrequent, {}};
    const std::size_t most = all.isFrequent ? limits.maxLabels : limits.maxLabels / rareShare;
    for (const WordAssociation::Meant& meant : all.labels)
      if (some.labels.size() < most && isListed(all.word, meant.label)) some.labels.push_back(meant);
    if (some.isFrequent || (!some.labels.empty() && some.labels.front().percent >= limits.minRarePercent))
      selected.push_back(std::move(some));
  }
  return selected;
}

PackedAssociations packAssociations(const std::vector<WordAssociation>& associations) {
  PackedAssociations packed;
  for (const WordAssociation& association : associations)
    for (const WordAssociation::Meant& meant : association.labels) packed.labels.push_back(meant.label);
  std::sort(packed.labels.begin(), packed.labels.end());
  packed.labels.erase(std::unique(packed.labels.begin(), packed.labels.end()), packed.labels.end());
  if (packed.labels.size() > packedDigits.size() * packedDigits.size())
    fail(ErrorCode::invalidInput, "packAssociations: {} labels, at most 1,296 fit", packed.labels.size());
  std::string_view before;
  for (const auto& [word, isFrequent, labels] : associations) {
    if (word <= before || word.find_first_not_of("abcdefghijklmnopqrstuvwxyz '") != std::string::npos)
      fail(ErrorCode::invalidInput, "packAssociations: \"{}\" is no letters in lower case, or not sorted",
           word);
    const auto [differs, other] = std::mismatch(word.begin(), word.end(), before.begin(), before.end());
    const std::size_t shared =
        std::min(static_cast<std::size_t>(differs - word.begin()), packedDigits.size() - 1);
    packed.text += packedDigits[shared];
    packed.text.append(word, shared);
    for (const WordAssociation::Meant& meant : labels) {
      const auto at = std::lower_bound(packed.labels.begin(), packed.labels.end(), meant.label);
      packed.text +=
          twoDigits(static_cast<std::size_t>(at - packed.labels.begin())) + twoDigits(meant.percent);
    }
    before = word;
  }
  return packed;
}

std::string packWordFilter(const std::vector<std::string_view>& words) {
  std::string bytes((10 * words.size() + 7) / 8, '\0');
  for (const std::string_view word : words) {
    const std::uint64_t a = hashOf(word, 2166136261U), b = hashOf(word, 40389U);
    for (std::uint64_t i = 0; i < bitsSet; ++i) {
      const std::uint64_t at = (a + i * b) % (8 * bytes.size());
      bytes[at / 8] = static_cast<char>(static_cast<unsigned char>(bytes[at / 8]) | (1U << (at % 8)));
    }
  }
  return toBase64(bytes);
}

}  // namespace estancia
