// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/label_words.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <tuple>

#include "estancia/core/ascii.hpp"

namespace estancia {
namespace {

using Words = std::vector<std::string>;

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// "n01440764": how ImageNet's label files number their lines.
bool isWordNetNumber(std::string_view word) {
  return word.size() == 9 && word[0] == 'n' && std::all_of(word.begin() + 1, word.end(), isDigit);
}

/// Lower-case words (Latin-1, too): runs of letters, digits and anything beyond ASCII.
Words splitWords(std::string_view text) {
  Words words;
  bool inside = false;
  unsigned char before = 0;
  for (const char character : text) {
    auto c = static_cast<unsigned char>(lowerCase(character));
    if (before == 0xC3 && c >= 0x80 && c <= 0x9E && c != 0x97) c = static_cast<unsigned char>(c + 0x20);
    before = c;
    const bool belongs = c >= 0x80 || isLetterOrDigit(static_cast<char>(c));
    if (belongs && !inside) words.emplace_back();
    if (belongs) words.back() += static_cast<char>(c);
    inside = belongs || (inside && c == '\'');  // "jack-o'-lantern", "cat's"
  }
  if (words.size() > 1 && isWordNetNumber(words.front())) words.erase(words.begin());
  return words;
}

std::vector<Words> synonymsOf(std::string_view label) {
  std::vector<Words> synonyms;
  while (true) {
    const std::size_t comma = label.find(',');
    Words words = splitWords(label.substr(0, comma));
    if (!words.empty()) synonyms.push_back(std::move(words));
    if (comma == std::string_view::npos) return synonyms;
    label.remove_prefix(comma + 1);
  }
}

/// The word and what it may be the (English) plural of.
Words singularForms(const std::string& word) {
  Words forms{word};
  const auto endsWith = [&word](std::string_view ending) {
    return word.size() > ending.size() + 1 && word.ends_with(ending);
  };
  const auto add = [&](std::size_t dropped, const char* ending) {
    forms.push_back(word.substr(0, word.size() - dropped) + ending);
  };
  if (!endsWith("s") || endsWith("ss")) return forms;
  add(1, "");
  if (endsWith("ies")) add(3, "y");
  if (endsWith("ves")) {
    add(3, "f");
    add(3, "fe");
  }
  for (const char* ending : {"ses", "xes", "zes", "ches", "shes", "oes"})
    if (endsWith(ending)) add(2, "");
  return forms;
}

/// Equal but for plural forms.
bool isSameWord(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const Words formsOfA = singularForms(a), formsOfB = singularForms(b);
  return std::find_first_of(formsOfA.begin(), formsOfA.end(), formsOfB.begin(), formsOfB.end()) !=
         formsOfA.end();
}

/// Whether `longer` holds the words of `shorter` one after the other.
bool holds(const Words& longer, const Words& shorter) {
  return std::search(longer.begin(), longer.end(), shorter.begin(), shorter.end(), isSameWord) !=
         longer.end();
}

std::string joined(const Words& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

/// Labels found by each of the rules of findLabels().
using LabelsByRule = std::array<std::vector<std::size_t>, 4>;

LabelsByRule labelsByRule(const Vocabulary& vocabulary, std::string_view words) {
  const Words asked = splitWords(words);
  LabelsByRule found;
  if (asked.empty()) return found;
  std::size_t longest = 0;
  for (std::size_t label = 0; label < vocabulary.size(); ++label) {
    std::array<bool, 3> byRule{};
    std::size_t held = 0;
    for (const Words& synonym : synonymsOf(vocabulary[label])) {
      byRule[0] |= synonym == asked;
      byRule[1] |= synonym.size() == asked.size() && holds(synonym, asked);
      byRule[2] |= holds(synonym, asked);
      if (holds(asked, synonym)) held = std::max(held, synonym.size());
    }
    for (std::size_t rule = 0; rule < byRule.size(); ++rule)
      if (byRule[rule]) found[rule].push_back(label);
    if (held > longest) found[3].clear();
    longest = std::max(longest, held);
    if (held > 0 && held == longest) found[3].push_back(label);
  }
  return found;
}

}  // namespace

std::vector<std::size_t> findLabels(const Vocabulary& vocabulary, std::string_view words) {
  LabelsByRule found = labelsByRule(vocabulary, words);
  for (std::vector<std::size_t>& labels : found)
    if (!labels.empty()) return std::move(labels);
  return {};
}

std::vector<std::size_t> labelsNamed(const Vocabulary& vocabulary, std::string_view words) {
  LabelsByRule found = labelsByRule(vocabulary, words);
  return found[0].empty() ? found[1] : found[0];
}

bool sameWords(std::string_view a, std::string_view b) {
  const Words wordsOfA = splitWords(a), wordsOfB = splitWords(b);
  return !wordsOfA.empty() && wordsOfA.size() == wordsOfB.size() && holds(wordsOfA, wordsOfB);
}

std::vector<std::string> findNearSpellings(const Vocabulary& vocabulary, std::string_view words,
                                           std::size_t count) {
  const std::string asked = joined(splitWords(words));
  constexpr std::size_t maxLength = 100;  // maximum length of a word that may be misspelled
  if (asked.empty() || asked.size() > maxLength) return {};
  const std::size_t maxDistance = std::max<std::size_t>(1, asked.size() / 3);
  // Whole synonyms before words of them, then by the alphabet.
  std::set<std::tuple<std::size_t, bool, std::string>> near;
  const auto consider = [&](const std::string& candidate, bool part) {
    const std::size_t distance = editDistance(asked, candidate);
    if (distance <= maxDistance && distance < candidate.size()) near.emplace(distance, part, candidate);
  };
  for (const std::string& label : vocabulary.labels())
    for (const Words& synonym : synonymsOf(label)) {
      consider(joined(synonym), false);
      if (synonym.size() > 1)
        for (const std::string& word : synonym) consider(word, true);
    }
  std::vector<std::string> spellings;
  for (const auto& [distance, part, candidate] : near)
    if (spellings.size() < count &&
        std::find(spellings.begin(), spellings.end(), candidate) == spellings.end())
      spellings.push_back(candidate);
  return spellings;
}

std::string shortLabel(std::string_view label) {
  std::string first(label.substr(0, label.find(',')));
  if (first.size() > 10 && isWordNetNumber(std::string_view(first).substr(0, 9)) && first[9] == ' ')
    first.erase(0, 10);
  return first;
}

std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::vector<std::size_t> bestLabels(DescriptorView probabilities, std::size_t count) {
  std::vector<std::size_t> order(probabilities.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return probabilities[a] != probabilities[b] ? probabilities[a] > probabilities[b]
                                                                  : a < b;
                    });
  order.resize(count);
  return order;
}

}  // namespace estancia
