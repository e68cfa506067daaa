// WordNet: synsets of English words with definitions and relations, read from its text files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

enum class PartOfSpeech : std::uint8_t { noun, verb, adjective, adverb };
constexpr std::size_t partsOfSpeech = 4;

/// Files of nouns in WordNet (lexnames(5WN)) that this project distinguishes.
enum class WordCategory : std::uint8_t {
  tops = 3,
  act = 4,
  animal = 5,
  artifact = 6,
  body = 8,
  communication = 10,
  food = 13,
  group = 14,
  location = 15,
  object = 17,
  person = 18,
  plant = 20,
  substance = 27,
};

/// A set of synonyms with one meaning.
struct WordNetSynset {
  PartOfSpeech pos = PartOfSpeech::noun;
  /// Byte offset in the file of its part of speech: "n03063599" is noun 3063599.
  std::uint32_t offset = 0;
  WordCategory category{};
  /// The synonyms as the file spells them, with spaces for underscores: "coffee mug".
  std::vector<std::string> words;
  /// How often each of `words` was tagged with this meaning in WordNet's text corpora.
  std::vector<std::uint32_t> tagCounts;
  struct Relation {
    /// WordNet's pointer symbol (wninput(5WN)): "@" hypernym, "#p" part of, "+" derivationally related …
    std::string symbol;
    PartOfSpeech pos = PartOfSpeech::noun;
    /// Index of a synset in WordNet::synsets.
    std::uint32_t target = 0;
  };
  std::vector<Relation> relations;
  /// Definition; then examples, in quotes.
  std::string gloss;
  /// The gloss without examples.
  std::string_view definition() const { return std::string_view(gloss).substr(0, gloss.find('"')); }
};

/// A word form and the meanings that it may have, most frequent first.
struct WordNetEntry {
  std::string word;
  PartOfSpeech pos = PartOfSpeech::noun;
  /// Indices in WordNet::synsets.
  std::vector<std::uint32_t> synsets;
};

/// G. A. Miller (1995): WordNet: a lexical database for English. Communications of the ACM 38 (11).
struct WordNet {
  /// Nouns, verbs, adjectives, adverbs, each by offset.
  std::vector<WordNetSynset> synsets;
  /// Lower-case words of the index files.
  std::vector<WordNetEntry> entries;
  struct IrregularForm {
    std::string form, word;
    PartOfSpeech pos = PartOfSpeech::noun;
  };
  /// "mice" → "mouse".
  std::vector<IrregularForm> irregularForms;
};

/// The files that readWordNet() needs, of a folder.
std::vector<std::filesystem::path> wordNetFiles(const std::filesystem::path& folder);

/// $ESTANCIA_WORDNET, else /usr/share/wordnet (Debian's wordnet-base); nothing where that has no WordNet.
std::optional<std::filesystem::path> findWordNet();

/// Reads WordNet 3.0 or 3.1 (wndb(5WN)). Throws Error (fileUnreadable, malformedFile, tooLarge).
WordNet readWordNet(const std::filesystem::path& folder);

}  // namespace estancia
