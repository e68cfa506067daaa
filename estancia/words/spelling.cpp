// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/spelling.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace estancia {
namespace {

constexpr std::size_t maxLetters = 40, minPart = 3;
constexpr double maxEdits = 2;
// Costs of edits: doubling a letter, or leaving the second out, is the commonest slip, then one vowel for
// another; the first letter is seldom wrong (Damerau 1964; Pollock & Zamora 1984).
constexpr double doubledCost = 0.5, vowelCost = 0.7, firstLetterCost = 0.5;
// A word ten times as frequent is worth a fifth of an edit, a word of the vocabulary three fifths.
constexpr double frequencyBonus = 0.2, preferredBonus = 0.6;

bool isPlainWord(std::string_view word) {
  return std::all_of(word.begin(), word.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

/// One bit a letter that occurs.
std::uint32_t lettersOf(std::string_view word) {
  std::uint32_t letters = 0;
  for (const char c : word)
    if (c >= 'a' && c <= 'z') letters |= 1u << (c - 'a');
  return letters;
}

bool isVowel(char c) {
  return std::string_view("aeiouy").find(c) != std::string_view::npos;
}

/// Restricted Damerau–Levenshtein distance in which doubling a letter costs half, and a vowel is nearer to
/// another than to a consonant. Lengths ≤ maxLetters + 2.
double costOf(std::string_view written, std::string_view meant) {
  std::array<std::array<double, maxLetters + 4>, 3> rows{};
  const auto gap = [](std::string_view text, std::size_t i) {
    return i > 1 && text[i - 1] == text[i - 2] ? doubledCost : 1.0;
  };
  const auto replaced = [](char a, char b) {
    return a == b ? 0 : isVowel(a) && isVowel(b) ? vowelCost : 1.0;
  };
  for (std::size_t j = 1; j <= meant.size(); ++j) rows[0][j] = rows[0][j - 1] + gap(meant, j);
  for (std::size_t i = 1; i <= written.size(); ++i) {
    auto& row = rows[i % 3];
    const auto &last = rows[(i + 2) % 3], &before = rows[(i + 1) % 3];
    row[0] = last[0] + gap(written, i);
    for (std::size_t j = 1; j <= meant.size(); ++j) {
      row[j] = std::min({last[j] + gap(written, i), row[j - 1] + gap(meant, j),
                         last[j - 1] + replaced(written[i - 1], meant[j - 1])});
      if (i > 1 && j > 1 && written[i - 1] == meant[j - 2] && written[i - 2] == meant[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return rows[written.size() % 3][meant.size()];
}

std::string twoWords(const Lexicon& lexicon, std::string_view word) {
  for (std::size_t at = minPart; at + minPart <= word.size(); ++at) {
    const std::string joined = std::string(word.substr(0, at)) + ' ' + std::string(word.substr(at));
    if (lexicon.knows(joined)) return joined;
  }
  return "";
}

}  // namespace

std::string correctSpelling(const Lexicon& lexicon, const std::vector<std::string>& preferred,
                            std::string_view word) {
  if (word.size() < minPart || word.size() > maxLetters || !isPlainWord(word)) return "";
  if (std::string two = twoWords(lexicon, word); !two.empty()) return two;
  const double limit = std::min(maxEdits, std::max(1.0, static_cast<double>(word.size()) / 4));
  const std::uint32_t letters = lettersOf(word);
  std::string best;
  double lowest = 1e9;
  const auto consider = [&](std::string_view candidate, double frequency, bool isPreferred) {
    const std::size_t longer = std::max(candidate.size(), word.size()),
                      shorter = std::min(candidate.size(), word.size());
    if (candidate.size() < minPart || longer - shorter > 2 ||
        std::popcount(lettersOf(candidate) ^ letters) > 4 || !isPlainWord(candidate))
      return;
    double cost = costOf(word, candidate);
    if (cost > limit) return;
    cost += (candidate.front() == word.front() ? 0 : firstLetterCost) -
            frequencyBonus * std::log10(1 + frequency) - (isPreferred ? preferredBonus : 0);
    if (cost < lowest || (cost == lowest && candidate < best)) {
      lowest = cost;
      best = candidate;
    }
  };
  for (std::size_t i = 0; i < lexicon.size(); ++i) {
    const std::string_view candidate = lexicon.word(i);
    consider(candidate, lexicon.frequencies[i],
             std::binary_search(preferred.begin(), preferred.end(), candidate, std::less<>()));
  }
  constexpr double functionFrequency = 1000;  // "somthing": WordNet has no function words
  for (const std::string_view candidate : functionWords()) consider(candidate, functionFrequency, false);
  return best;
}

}  // namespace estancia
