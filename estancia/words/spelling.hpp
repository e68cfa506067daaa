// Spelling: the known word that an unknown one most probably stands for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "estancia/words/lexicon.hpp"

namespace estancia {

/// Two known words that were written as one ("livingroom" → "living room"), else the known word of the
/// smallest edit distance, at most two and a quarter of the length (one edit is always allowed; a letter
/// doubled counts half, one vowel for another less than a whole): of several, frequent words and `preferred`
/// ones (sorted, single words) go first. "" when there is none. Letters only; longer words than 40 letters
/// have none.
std::string correctSpelling(const Lexicon& lexicon, const std::vector<std::string>& preferred,
                            std::string_view word);

}  // namespace estancia
