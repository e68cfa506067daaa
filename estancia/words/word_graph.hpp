// Word graph: WordNet's synsets joined by relations and definitions; random walks measure relatedness.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/words/lexicon.hpp"
#include "estancia/words/wordnet.hpp"

namespace estancia {

/// Relation of two synsets, seen from the first.
enum class WordLink : std::uint8_t {
  /// The second is more general: its hypernym.
  kindOf,
  moreGeneral,
  partOf,
  hasPart,
  /// Members, substances, attributes, causes, domains, derived and similar words.
  related,
  /// The definition of the first names the second.
  defines,
  /// The definition of the second names the first.
  definedBy,
  /// The name of the first holds a word of the second: "coffee mug" and "coffee".
  named,
  nameOf,
};

/// For each synset what it serves: verbs, and what those are done to (findPurposes()).
struct WordPurposes {
  /// One more than synsets: offsets in the next two.
  std::vector<std::uint32_t> starts{0};
  std::vector<std::uint32_t> synsets;
  /// How surely that meaning of the definition's word is meant, in (0, 1].
  std::vector<float> shares;
};

/// An undirected weighted graph over all synsets, with the words that lead into it.
struct WordGraph {
  Lexicon lexicon;

  /// One name a synset: its first word.
  std::string nameText;
  /// size() + 1 offsets in `nameText`.
  std::vector<std::uint32_t> nameStarts{0};
  std::vector<std::uint8_t> categories;
  /// Byte offset in WordNet's file, which ImageNet's numbers name.
  std::vector<std::uint32_t> offsets;

  /// Edges of each synset, both ways: size() + 1 offsets in the next three.
  std::vector<std::uint32_t> edgeStarts{0};
  std::vector<std::uint32_t> edgeTargets;
  /// > 0, the same in both directions.
  std::vector<float> edgeWeights;
  std::vector<std::uint8_t> edgeLinks;
  /// Sum of each synset's edges; > 0 unless it has none. Not stored in files.
  std::vector<float> degrees;
  double degreeSum = 0;

  WordPurposes purposes;

  std::size_t size() const { return offsets.size(); }
  std::string_view name(std::uint32_t synset) const;
  WordCategory category(std::uint32_t synset) const { return static_cast<WordCategory>(categories[synset]); }
  PartOfSpeech pos(std::uint32_t synset) const;
  /// Sets degrees and degreeSum.
  void sumDegrees();

  /// Where a walker is who starts at one of `from` (by its probability) and, `steps` times, goes on along an
  /// edge with probability `persistence`, else starts again: personalized PageRank (Haveliwala 2002; for
  /// words: Hughes & Ramage 2007, Agirre & Soroa 2009), cut off after a few steps. One value a synset.
  std::vector<float> walk(std::span<const Sense> from) const;

  /// walk() from up to `together` starts in one go, with the same sums: every edge is fetched once a step for
  /// all of them, which costs a third of the time. Row-major, one row of `together` values a synset.
  std::vector<float> walkTogether(std::span<const std::vector<Sense>> starts) const;
  static constexpr std::size_t together = 8;

  /// walk() from each of any number of starts, several at once.
  std::vector<std::vector<float>> walkEach(std::span<const std::vector<Sense>> starts) const;

  /// log of how much more often that walker meets a synset than one who walks for ever: pointwise mutual
  /// information. At least `minLift` where the walker cannot get.
  double lift(const std::vector<float>& visits, std::uint32_t synset) const;
  static constexpr double minLift = -7;

  /// A synset's hypernyms of any distance with that distance, itself (0) first.
  std::vector<std::pair<std::uint32_t, int>> hypernyms(std::uint32_t synset) const;
};

/// Joins all synsets of WordNet. A definition (without examples) names those meanings of its words that have
/// a fair share of their uses: extended gloss overlap (Banerjee & Pedersen 2003) as edges.
WordGraph buildWordGraph(const WordNet& wordNet);

}  // namespace estancia
