// Label search: finds labels by words (synonyms, plurals, misspellings), ranks and shortens them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Indices of the labels that `words` mean. A label line holds synonyms between commas ("cup, mug"); case,
/// hyphens, underscores and a leading WordNet number do not matter. The first of these rules that finds
/// a label counts: a synonym equals the words; equals them but for plural forms; contains them as whole words
/// ("dining table" contains "table"); is contained in them ("red umbrella" contains "umbrella"; the longest
/// such synonyms). Empty when no rule does.
std::vector<std::size_t> findLabels(const Vocabulary& vocabulary, std::string_view words);

/// Labels found by the first two of these rules: those of exactly that name.
std::vector<std::size_t> labelsNamed(const Vocabulary& vocabulary, std::string_view words);

/// Whether the two are equal but for case, hyphens, underscores and plural forms.
bool sameWords(std::string_view a, std::string_view b);

/// Up to `count` synonyms, or words of them, spelled nearly like `words` (Damerau–Levenshtein distance of at
/// most a third of the length), nearest first.
std::vector<std::string> findNearSpellings(const Vocabulary& vocabulary, std::string_view words,
                                           std::size_t count = 3);

/// The first synonym of a label line, for people: "n03063599 coffee mug, cup" → "coffee mug".
std::string shortLabel(std::string_view label);

/// The `count` most probable labels, best first, as label indices; of equal ones the first.
std::vector<std::size_t> bestLabels(DescriptorView probabilities, std::size_t count);

/// Restricted Damerau–Levenshtein distance by bytes: insertions, deletions, substitutions, neighbors' swaps.
std::size_t editDistance(std::string_view a, std::string_view b);

}  // namespace estancia
