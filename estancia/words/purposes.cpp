// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/purposes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

namespace estancia {
namespace {

constexpr int maxHypernyms = 2;
constexpr double generalDecay = 0.8;
/// Meanings that are less sure are left out, as in the graph's edges.
constexpr float minShare = 0.1F;
/// Number of words after the verb that may name the object of a purpose.
constexpr std::size_t maxObjects = 5;

bool isGerund(std::string_view word) {
  return word.ends_with("ing");
}

std::vector<std::string> clausesOf(std::string_view definition) {
  std::vector<std::string> clauses(1);
  for (const char c : definition) {
    if (c == ';' || c == '(' || c == ')')
      clauses.emplace_back();
    else
      clauses.back() += c;
  }
  return clauses;
}

/// Collects the purpose of a thing from one definition.
class Purpose {
 public:
  explicit Purpose(const WordGraph& graph) : graph_(graph) {}

  void read(const std::string& clause) {
    const std::vector<std::string> words = splitText(clause);
    std::size_t objectsLeft = 0;
    bool afterGerund = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (i + 1 < words.size() && leadsToVerb(words[i], words[i + 1], afterGerund) && addVerb(words[i + 1])) {
        afterGerund = isGerund(words[++i]);
        objectsLeft = maxObjects;
      } else if (objectsLeft > 0 && !isFunctionWord(words[i])) {
        --objectsLeft;
        for (const Sense& sense : graph_.lexicon.senses(words[i]))
          if (graph_.pos(sense.synset) != PartOfSpeech::verb) add(sense);
      }
    }
  }

  const std::map<std::uint32_t, float>& served() const { return served_; }

 private:
  static bool leadsToVerb(const std::string& word, const std::string& next, bool afterGerund) {
    if (word == "to") return !isFunctionWord(next);
    return isGerund(next) && (word == "for" || (afterGerund && (word == "and" || word == "or")));
  }

  /// Whether the word can be a verb.
  bool addVerb(const std::string& word) {
    std::vector<Sense> senses = graph_.lexicon.senses(word);
    std::erase_if(senses, [&](const Sense& sense) { return graph_.pos(sense.synset) != PartOfSpeech::verb; });
    float sum = 0;
    for (const Sense& sense : senses) sum += sense.probability;
    for (const Sense& sense : senses) add({sense.synset, sense.probability / sum});
    return !senses.empty();
  }

  void add(const Sense& sense) {
    for (const auto& [above, distance] : graph_.hypernyms(sense.synset)) {
      if (distance > maxHypernyms) continue;
      float& share = served_[above];
      share = std::max(share, sense.probability * static_cast<float>(std::pow(generalDecay, distance)));
    }
  }

  const WordGraph& graph_;
  std::map<std::uint32_t, float> served_;
};

}  // namespace

WordPurposes findPurposes(const WordNet& wordNet, const WordGraph& graph) {
  WordPurposes purposes;
  for (const WordNetSynset& synset : wordNet.synsets) {
    if (synset.pos == PartOfSpeech::noun) {
      Purpose purpose(graph);
      for (const std::string& clause : clausesOf(synset.definition())) purpose.read(clause);
      for (const auto& [served, share] : purpose.served()) {
        if (share < minShare) continue;
        purposes.synsets.push_back(served);
        purposes.shares.push_back(share);
      }
    }
    purposes.starts.push_back(static_cast<std::uint32_t>(purposes.synsets.size()));
  }
  return purposes;
}

float purposeShare(float common) {
  return std::sqrt(std::min(common, 1.0F));
}

std::vector<float> purposeShares(const WordGraph& graph, std::span<const std::vector<Sense>> terms,
                                 std::span<const std::uint32_t> things) {
  const WordPurposes& purposes = graph.purposes;
  std::vector<float> asked(graph.size(), 0), sums(things.size(), 0), shares(graph.size(), 0);
  std::vector<bool> servesVerb(things.size(), false);
  for (const std::vector<Sense>& senses : terms) {
    for (const Sense& sense : senses) asked[sense.synset] = sense.probability;
    for (std::size_t t = 0; t < things.size(); ++t) {
      float common = 0;
      for (std::uint32_t p = purposes.starts[things[t]]; p < purposes.starts[things[t] + 1]; ++p) {
        const float both = std::min(asked[purposes.synsets[p]], purposes.shares[p]);
        common += both;
        if (both > 0 && graph.pos(purposes.synsets[p]) == PartOfSpeech::verb) servesVerb[t] = true;
      }
      sums[t] += purposeShare(common);
    }
    for (const Sense& sense : senses) asked[sense.synset] = 0;
  }
  for (std::size_t t = 0; t < things.size(); ++t)
    if (servesVerb[t]) shares[things[t]] = sums[t] / static_cast<float>(terms.size());
  return shares;
}

}  // namespace estancia
