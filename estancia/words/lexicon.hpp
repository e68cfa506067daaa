// Lexicon: English words, their inflected forms, misspellings, and how probably they have which meaning.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/words/wordnet.hpp"

namespace estancia {

/// One meaning of a word.
struct Sense {
  std::uint32_t synset = 0;
  /// Its share of the word's uses, in (0, 1].
  float probability = 0;
};

/// The words of WordNet, sorted, in lower case with spaces for hyphens and underscores: "t shirt". Invariant:
/// `starts` and `senseStarts` have size() + 1 ascending offsets, checked when read from a file. Immutable
/// once made.
class Lexicon {
 public:
  Lexicon() = default;
  explicit Lexicon(const WordNet& wordNet);

  std::size_t size() const { return frequencies.size(); }
  std::string_view word(std::size_t i) const {
    return std::string_view(text).substr(starts[i], starts[i + 1] - starts[i]);
  }
  /// The exact word, not its inflected forms.
  std::optional<std::size_t> find(std::string_view word) const;
  /// Meanings of a word or an inflected form of it ("mice", "washing", "dog's"; Morphy, morphy(7WN)), of
  /// every part of speech, most probable first. Probabilities add up to 1. Empty for an unknown word. A
  /// meaning's share follows from its frequency in WordNet's tagged texts and its rank.
  std::vector<Sense> senses(std::string_view word) const;
  /// Nouns that it usually means: each with a fifth of its uses at least.
  std::vector<std::uint32_t> usualNouns(std::string_view word) const;
  /// How often the exact word was tagged with a meaning in WordNet's texts.
  std::uint32_t tagCount(std::string_view word, std::uint32_t synset) const;
  bool knows(std::string_view word) const { return !senses(word).empty(); }

  /// The words of a text that carry meaning, in order: function words ("something to …") are dropped, and
  /// words that WordNet has together ("living room") stay together, up to four of them. Unknown words remain.
  std::vector<std::string> terms(std::string_view text) const;

  // Parts that are stored in a file; see word_files.cpp.
  std::string text;
  /// size() + 1 offsets in `text`.
  std::vector<std::uint32_t> starts{0};
  /// size() + 1 offsets in the next two.
  std::vector<std::uint32_t> senseStarts{0};
  std::vector<std::uint32_t> senseSynsets;
  std::vector<float> senseWeights;
  /// How often each word was tagged in WordNet's texts.
  std::vector<std::uint32_t> frequencies;
  /// First synset of each part of speech, and the end.
  std::array<std::uint32_t, partsOfSpeech + 1> firstSynset{};

 private:
  /// Adds the entry's meanings; returns how often they were tagged.
  std::uint32_t addEntry(const WordNet& wordNet, const WordNetEntry& entry);
  /// The first entry that does not go before `sought`.
  std::size_t lowerBound(std::string_view sought) const;
  bool startsEntry(std::string_view beginning) const;
  void addSenses(std::string_view word, std::optional<PartOfSpeech> pos, std::vector<Sense>& senses) const;
};

/// Lower-case words of a text: runs of letters, digits, apostrophes inside, and anything beyond ASCII.
std::vector<std::string> splitText(std::string_view text);

/// Normal form of the lexicon: lower case, spaces for hyphens and underscores.
std::string lexicalForm(std::string_view word);

/// Whether the word only serves grammar: "the", "of", "something".
bool isFunctionWord(std::string_view word);

/// "the kitchen" → "kitchen"; the words as they are where nothing else is left.
std::string withoutFunctionWords(std::string_view words);

/// Sorted.
std::span<const std::string_view> functionWords();

/// Two known words that were written as one ("livingroom" → "living room"), else the known word of the
/// smallest edit distance, at most two and a quarter of the length (one edit is always allowed; a letter
/// doubled counts half, one vowel for another less than a whole): of several, frequent words and `preferred`
/// ones (sorted, single words) go first. "" when there is none. Letters only, at most 40.
std::string correctSpelling(const Lexicon& lexicon, const std::vector<std::string>& preferred,
                            std::string_view word);

}  // namespace estancia
