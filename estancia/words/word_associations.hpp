// Word associations: for each English word the labels that a person who asks for it means, all at once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

struct WordGraph;

/// A word and the labels that LabelSearch finds for it.
struct WordAssociation {
  std::string word;
  /// Whether it was tagged in WordNet's texts.
  bool isFrequent = false;
  struct Meant {
    std::uint32_t label = 0;
    /// The probability, rounded.
    std::uint8_t percent = 0;
    bool operator==(const Meant&) const = default;
  };
  /// Most probable first, of equal ones the first label; empty: the word is known and means none.
  std::vector<Meant> labels;
  bool operator==(const WordAssociation&) const = default;
};

/// A word of one or two words that people type: letters in lower case, with a blank or apostrophes between.
bool isTypedWord(std::string_view word);

/// Associations of the words that a person would type: one or two words, in letters alone, that are frequent
/// or mean a label; sorted. Labels are the LabelSearch::likely() ones. `threads`: 0 for one a usable core,
/// with the same result. It walks from the labels in place of the words: the graph is undirected, so
/// visits_a[b] / degree[b] = visits_b[a] / degree[a].
std::vector<WordAssociation> associateWords(const WordGraph& graph, const Vocabulary& vocabulary,
                                            int threads = 0, Progress& progress = Progress::none());

struct AssociationLimits {
  /// Min probability of the best label of a rare word, so that it is worth its space.
  int minRarePercent = 50;
  /// Max labels of a word; a quarter of it for rare words.
  std::size_t maxLabels = 20;
};

/// Selects associations of the labels for which `isListed` holds.
std::vector<WordAssociation> selectAssociations(
    const std::vector<WordAssociation>& associations,
    const std::function<bool(const std::string& word, std::uint32_t label)>& isListed,
    const AssociationLimits& limits = {});

/// For scripts: words sorted, one after another, each as the number of letters that it shares with the word
/// before (one digit), its other letters, and its labels. A label has four digits: its position in the
/// ascending list of all that occur (two), and its probability in percent (two). Digits are of base 36, in
/// upper case; a word shares at most 35 letters.
struct PackedAssociations {
  /// Labels that occur, ascending.
  std::vector<std::uint32_t> labels;
  std::string text;
};

/// Throws Error (invalidInput) for more than 1,296 labels, words that are not sorted, or a word of other
/// characters than letters in lower case, blanks and apostrophes.
PackedAssociations packAssociations(const std::vector<WordAssociation>& associations);

/// A Bloom filter (Bloom 1970) of ASCII words in base64: 10 bits a word, 7 of them set, so that of words that
/// are not in it one in a hundred is taken for one that is. Bits count from the lowest one of the first byte;
/// those of a word are (a + i b) mod the number of bits, i from 0 to 6, where a and b are its FNV-1a hashes
/// of 32 bits from the bases 2166136261 and 40389 (double hashing: Kirsch & Mitzenmacher 2006).
std::string packWordFilter(const std::vector<std::string_view>& words);

}  // namespace estancia
