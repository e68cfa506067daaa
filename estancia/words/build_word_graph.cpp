// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "estancia/words/purposes.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia {
namespace {

// Weights of edges, chosen on the even queries of lab/experiments/words/queries.csv and the training half of
// NYU's rooms; half or twice any of them moves the results by less than the queries' spread.
constexpr float definitionWeight = 0.6F, compoundWeight = 0.6F, nameWeight = 0.3F;
constexpr float memberWeight = 0.3F, similarWeight = 0.5F, otherWeight = 0.3F;
/// Meanings of a word in a definition that have a smaller share of its uses are left out.
constexpr float minSenseShare = 0.1F;

struct Edge {
  std::uint32_t from, to;
  float weight;
  WordLink link;
};

struct PointerKind {
  float weight;
  WordLink link;
};

/// Weight and link of a pointer of WordNet; weight 0: no edge. Antonyms get weight 0.
PointerKind kindOf(std::string_view symbol) {
  if (symbol == "@" || symbol == "@i") return {1, WordLink::kindOf};
  if (symbol == "~" || symbol == "~i") return {1, WordLink::moreGeneral};
  if (symbol == "#p") return {1, WordLink::partOf};
  if (symbol == "%p") return {1, WordLink::hasPart};
  if (symbol == "#m" || symbol == "#s") return {memberWeight, WordLink::partOf};
  if (symbol == "%m" || symbol == "%s") return {memberWeight, WordLink::hasPart};
  if (symbol == "+") return {1, WordLink::related};
  if (symbol == "&") return {similarWeight, WordLink::related};
  for (const char* other : {"=", "*", ">", "^", "\\", "<", ";c", "-c"})
    if (symbol == other) return {otherWeight, WordLink::related};
  return {0, WordLink::related};
}

WordLink reverse(WordLink link) {
  using enum WordLink;
  for (const auto& [one, other] :
       {std::pair(kindOf, moreGeneral), {partOf, hasPart}, {defines, definedBy}, {named, nameOf}}) {
    if (link == one) return other;
    if (link == other) return one;
  }
  return related;
}

/// Whether one of the two is a kind of the other; hypernyms() follows these.
bool isOfKinds(WordLink link) {
  return link == WordLink::kindOf || link == WordLink::moreGeneral;
}

/// Collects the edges of one synset to others, merging those to the same one.
class EdgeList {
 public:
  void add(std::uint32_t from, std::uint32_t to, float weight, WordLink link) {
    if (from != to && weight > 0) edges_.push_back({from, to, weight, link});
  }

  /// Edges of both directions, sorted, one a pair: weights added up; the link is the hypernym's where there
  /// is one (a definition mostly names it, too), else that of the heaviest.
  void mergeInto(WordGraph& graph) {
    std::vector<std::size_t> ends(graph.size() + 1, 0);  // ends of each synset's edges, once they are placed
    for (const Edge& edge : edges_) ++ends[edge.from + 1];
    for (std::size_t i = 0; i < graph.size(); ++i) ends[i + 1] += ends[i];
    std::vector<Edge> placed(edges_.size());
    for (const Edge& edge : edges_) placed[ends[edge.from]++] = edge;
    graph.edgeStarts.assign(1, 0);
    for (std::size_t i = 0, at = 0; i < graph.size(); ++i) {
      const auto begin = placed.begin() + static_cast<std::ptrdiff_t>(at);
      std::stable_sort(
          begin, placed.begin() + static_cast<std::ptrdiff_t>(ends[i]), [](const Edge& a, const Edge& b) {
            if (a.to != b.to) return a.to < b.to;
            return isOfKinds(a.link) != isOfKinds(b.link) ? isOfKinds(a.link) : a.weight > b.weight;
          });
      while (at < ends[i]) {
        Edge merged = placed[at];
        for (++at; at < ends[i] && placed[at].to == merged.to; ++at) merged.weight += placed[at].weight;
        graph.edgeTargets.push_back(merged.to);
        graph.edgeWeights.push_back(merged.weight);
        graph.edgeLinks.push_back(static_cast<std::uint8_t>(merged.link));
      }
      graph.edgeStarts.push_back(static_cast<std::uint32_t>(graph.edgeTargets.size()));
    }
  }

 private:
  std::vector<Edge> edges_;
};

/// Words, each once, with all that they may mean.
class Meanings {
 public:
  explicit Meanings(const Lexicon& lexicon) : lexicon_(lexicon), shares_(lexicon.firstSynset.back(), 0) {}

  /// Joins `synset` and what the words mean, both ways.
  void join(std::uint32_t synset, std::vector<std::string> words, float weight, WordLink link,
            EdgeList& edges) {
    std::sort(words.begin(), words.end());
    words.erase(std::unique(words.begin(), words.end()), words.end());
    std::vector<std::uint32_t> named;
    for (const std::string& word : words)
      for (const Sense& sense : sensesOf(word)) {
        if (shares_[sense.synset] == 0) named.push_back(sense.synset);
        shares_[sense.synset] += sense.probability;
      }
    for (const std::uint32_t meant : named) {
      const float share = std::exchange(shares_[meant], 0.0F);
      if (share < minSenseShare) continue;
      edges.add(synset, meant, weight * share, link);
      edges.add(meant, synset, weight * share, reverse(link));
    }
  }

 private:
  const std::vector<Sense>& sensesOf(const std::string& word) {
    const auto [at, isNew] = known_.try_emplace(word);
    if (isNew) at->second = lexicon_.senses(word);
    return at->second;
  }

  const Lexicon& lexicon_;
  /// Share of each synset; 0 between calls.
  std::vector<float> shares_;
  std::unordered_map<std::string, std::vector<Sense>> known_;
};

/// The words that a compound is made of: "kitchen appliance" → "kitchen", "appliance"; none for one word.
std::vector<std::string> partsOf(const std::string& word) {
  std::vector<std::string> parts = splitText(word);
  if (parts.size() < 2) return {};
  std::erase_if(parts, [](const std::string& part) { return part.size() < 2 || isFunctionWord(part); });
  return parts;
}

}  // namespace

WordGraph buildWordGraph(const WordNet& wordNet) {
  WordGraph graph;
  graph.lexicon = Lexicon(wordNet);
  for (const WordNetSynset& synset : wordNet.synsets) {
    graph.nameText += synset.words.front();
    graph.nameStarts.push_back(static_cast<std::uint32_t>(graph.nameText.size()));
    graph.categories.push_back(static_cast<std::uint8_t>(synset.category));
    graph.offsets.push_back(synset.offset);
  }
  EdgeList edges;
  Meanings meanings(graph.lexicon);
  for (std::uint32_t s = 0; s < wordNet.synsets.size(); ++s) {
    const WordNetSynset& synset = wordNet.synsets[s];
    for (const WordNetSynset::Relation& relation : synset.relations) {
      // WordNet names a relation in both synsets but for a few kinds; each direction is added from its side.
      const PointerKind kind = kindOf(relation.symbol);
      edges.add(s, relation.target, kind.weight / 2, kind.link);
      edges.add(relation.target, s, kind.weight / 2, reverse(kind.link));
    }
    const std::vector<std::string> words = graph.lexicon.terms(synset.definition());
    std::vector<std::string> parts, own;
    for (const std::string& word : words) {
      const std::vector<std::string> of = partsOf(word);
      parts.insert(parts.end(), of.begin(), of.end());
    }
    if (synset.pos == PartOfSpeech::noun)
      for (const std::string& name : synset.words) {
        if (name.front() < 'a' || name.front() > 'z') continue;  // proper names
        const std::vector<std::string> of = partsOf(name);
        own.insert(own.end(), of.begin(), of.end());
      }
    meanings.join(s, words, definitionWeight, WordLink::defines, edges);
    meanings.join(s, parts, compoundWeight, WordLink::defines, edges);
    meanings.join(s, own, nameWeight, WordLink::named, edges);
  }
  edges.mergeInto(graph);
  graph.sumDegrees();
  graph.purposes = findPurposes(wordNet, graph);
  return graph;
}

}  // namespace estancia
