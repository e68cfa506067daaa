// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/lexicon.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <unordered_map>
#include <utility>

#include "estancia/core/ascii.hpp"

namespace estancia {
namespace {

// How much a part of speech counts: labels are nouns; verbs describe their purposes.
constexpr std::array<float, partsOfSpeech> posWeights = {1.0F, 0.7F, 0.5F, 0.1F};
/// Added to each meaning's count, so that one that no text has keeps a share.
constexpr float unseenCount = 0.3F;
/// A meaning that is rarer is not what is meant by a word that stands alone.
constexpr float minUsualShare = 0.2F;
constexpr std::size_t maxTogether = 4;  // words of one entry

struct Ending {
  PartOfSpeech pos;
  std::string_view from, to;
};
/// Rules of detachment of Morphy, morphy(7WN).
constexpr std::array<Ending, 20> endings{{
    {PartOfSpeech::noun, "s", ""},        {PartOfSpeech::noun, "ses", "s"},
    {PartOfSpeech::noun, "xes", "x"},     {PartOfSpeech::noun, "zes", "z"},
    {PartOfSpeech::noun, "ches", "ch"},   {PartOfSpeech::noun, "shes", "sh"},
    {PartOfSpeech::noun, "men", "man"},   {PartOfSpeech::noun, "ies", "y"},
    {PartOfSpeech::verb, "s", ""},        {PartOfSpeech::verb, "ies", "y"},
    {PartOfSpeech::verb, "es", "e"},      {PartOfSpeech::verb, "es", ""},
    {PartOfSpeech::verb, "ed", "e"},      {PartOfSpeech::verb, "ed", ""},
    {PartOfSpeech::verb, "ing", "e"},     {PartOfSpeech::verb, "ing", ""},
    {PartOfSpeech::adjective, "er", ""},  {PartOfSpeech::adjective, "est", ""},
    {PartOfSpeech::adjective, "er", "e"}, {PartOfSpeech::adjective, "est", "e"},
}};

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

/// Restricted Damerau–Levenshtein distance by these costs. Lengths ≤ maxLetters + 2.
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

std::span<const std::string_view> functionWords() {
  static constexpr std::string_view words[] = {
      "a",        "about",   "across",    "after",     "against", "all",    "along",  "also",       "an",
      "and",      "another", "any",       "anything",  "are",     "around", "as",     "at",         "be",
      "because",  "been",    "before",    "being",     "between", "both",   "but",    "by",         "can",
      "could",    "did",     "do",        "does",      "during",  "each",   "eg",     "especially", "etc",
      "every",    "find",    "first",     "for",       "from",    "had",    "has",    "have",       "having",
      "he",       "her",     "him",       "his",       "how",     "i",      "ie",     "if",         "in",
      "into",     "is",      "it",        "its",       "like",    "made",   "make",   "many",       "may",
      "me",       "might",   "more",      "most",      "much",    "my",     "no",     "not",        "of",
      "off",      "often",   "on",        "one",       "only",    "or",     "other",  "others",     "our",
      "out",      "over",    "same",      "second",    "several", "she",    "should", "so",         "some",
      "somebody", "someone", "something", "somewhere", "such",    "than",   "that",   "the",        "their",
      "them",     "then",    "these",     "they",      "thing",   "things", "this",   "those",      "three",
      "through",  "to",      "two",       "under",     "up",      "upon",   "us",     "use",        "used",
      "uses",     "using",   "usually",   "very",      "was",     "we",     "were",   "what",       "when",
      "where",    "which",   "while",     "who",       "whom",    "whose",  "with",   "within",     "without",
      "you",      "your"};
  return words;
}

bool isFunctionWord(std::string_view word) {
  return std::ranges::binary_search(functionWords(), word);
}

std::string withoutFunctionWords(std::string_view words) {
  std::string rest;
  for (const std::string& word : splitText(words))
    if (!isFunctionWord(word)) rest += (rest.empty() ? "" : " ") + word;
  return rest.empty() ? std::string(words) : rest;
}

std::string lexicalForm(std::string_view word) {
  std::string form(word);
  unsigned char before = 0;
  for (char& c : form) {
    const auto byte = static_cast<unsigned char>(c);
    c = lowerCase(c);
    if (before == 0xC3 && byte >= 0x80 && byte <= 0x9E && byte != 0x97)
      c = static_cast<char>(byte + 0x20);  // capitals of Latin-1: "Ä" → "ä"
    if (c == '-' || c == '_') c = ' ';
    before = byte;
  }
  return form;
}

std::vector<std::string> splitText(std::string_view text) {
  std::vector<std::string> words;
  bool inside = false;
  std::string plain = lexicalForm(text);
  for (const std::string_view quote : {"\u2018", "\u2019"})  // "dog’s", as phones write it
    for (std::size_t at = 0; (at = plain.find(quote, at)) != std::string::npos;)
      plain.replace(at, quote.size(), "'");
  for (const char c : plain) {
    const auto byte = static_cast<unsigned char>(c);
    const bool letter = byte >= 0x80 || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (letter && !inside) words.emplace_back();
    if (letter || (inside && c == '\'')) words.back() += c;
    inside = letter || (inside && c == '\'');
  }
  for (std::string& word : words)
    while (word.ends_with('\'')) word.pop_back();
  return words;
}

Lexicon::Lexicon(const WordNet& wordNet) {
  using Form = std::pair<std::string, const WordNetEntry*>;
  std::vector<Form> forms;
  forms.reserve(wordNet.entries.size() + wordNet.irregularForms.size());
  std::array<std::unordered_map<std::string_view, const WordNetEntry*>, partsOfSpeech> entryOf;
  for (const WordNetEntry& entry : wordNet.entries) {
    forms.emplace_back(lexicalForm(entry.word), &entry);
    entryOf[static_cast<std::size_t>(entry.pos)][entry.word] = &entry;
  }
  for (const WordNet::IrregularForm& irregular : wordNet.irregularForms) {
    const auto& entries = entryOf[static_cast<std::size_t>(irregular.pos)];
    if (const auto entry = entries.find(irregular.word);
        entry != entries.end() && irregular.form != irregular.word)
      forms.emplace_back(lexicalForm(irregular.form), entry->second);
  }
  std::stable_sort(forms.begin(), forms.end(),
                   [](const Form& a, const Form& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < forms.size();) {
    const std::string& form = forms[i].first;
    std::uint32_t frequency = 0;
    for (; i < forms.size() && forms[i].first == form; ++i) frequency += addEntry(wordNet, *forms[i].second);
    text += form;
    starts.push_back(static_cast<std::uint32_t>(text.size()));
    senseStarts.push_back(static_cast<std::uint32_t>(senseSynsets.size()));
    frequencies.push_back(frequency);
  }
  for (const WordNetSynset& synset : wordNet.synsets) ++firstSynset[static_cast<std::size_t>(synset.pos) + 1];
  for (std::size_t p = 0; p < partsOfSpeech; ++p) firstSynset[p + 1] += firstSynset[p];
}

std::uint32_t Lexicon::addEntry(const WordNet& wordNet, const WordNetEntry& entry) {
  const std::string form = lexicalForm(entry.word);
  std::uint32_t sum = 0;
  for (std::size_t rank = 0; rank < entry.synsets.size(); ++rank) {
    const WordNetSynset& synset = wordNet.synsets[entry.synsets[rank]];
    std::uint32_t count = 0;
    for (std::size_t w = 0; w < synset.words.size(); ++w)
      if (synset.tagCounts[w] > count && lexicalForm(synset.words[w]) == form) count = synset.tagCounts[w];
    sum += count;
    senseSynsets.push_back(entry.synsets[rank]);
    senseWeights.push_back(posWeights[static_cast<std::size_t>(entry.pos)] *
                           (static_cast<float>(count) + unseenCount) / static_cast<float>(rank + 1));
  }
  return sum;
}

std::size_t Lexicon::lowerBound(std::string_view sought) const {
  std::size_t first = 0;
  for (std::size_t count = size(); count > 0;) {
    const std::size_t half = count / 2;
    const bool isBelow = word(first + half) < sought;
    if (isBelow) first += half + 1;
    count = isBelow ? count - half - 1 : half;
  }
  return first;
}

std::optional<std::size_t> Lexicon::find(std::string_view sought) const {
  const std::size_t at = lowerBound(sought);
  return at < size() && word(at) == sought ? std::optional(at) : std::nullopt;
}

std::uint32_t Lexicon::tagCount(std::string_view asked, std::uint32_t synset) const {
  const std::optional<std::size_t> at = find(lexicalForm(asked));
  if (!at) return 0;
  const auto pos = [&](std::uint32_t sense) {
    return static_cast<std::size_t>(std::upper_bound(firstSynset.begin() + 1, firstSynset.end() - 1, sense) -
                                    firstSynset.begin() - 1);
  };
  std::array<std::uint32_t, partsOfSpeech> ranks{};
  for (std::uint32_t s = senseStarts[*at]; s < senseStarts[*at + 1]; ++s) {
    const std::size_t p = pos(senseSynsets[s]);
    const auto rank = static_cast<float>(++ranks[p]);
    if (senseSynsets[s] == synset)
      return static_cast<std::uint32_t>(
          std::lround(std::max(0.0F, senseWeights[s] * rank / posWeights[p] - unseenCount)));
  }
  return 0;
}

void Lexicon::addSenses(std::string_view form, std::optional<PartOfSpeech> pos,
                        std::vector<Sense>& senses) const {
  const std::optional<std::size_t> at = find(form);
  if (!at) return;
  for (std::uint32_t s = senseStarts[*at]; s < senseStarts[*at + 1]; ++s) {
    const std::uint32_t synset = senseSynsets[s];
    if (pos && (synset < firstSynset[static_cast<std::size_t>(*pos)] ||
                synset >= firstSynset[static_cast<std::size_t>(*pos) + 1]))
      continue;
    const auto same = std::find_if(senses.begin(), senses.end(),
                                   [&](const Sense& sense) { return sense.synset == synset; });
    if (same == senses.end())
      senses.push_back({synset, senseWeights[s]});
    else
      same->probability = std::max(same->probability, senseWeights[s]);
  }
}

std::vector<Sense> Lexicon::senses(std::string_view asked) const {
  std::string form = lexicalForm(asked);
  std::vector<Sense> senses;
  addSenses(form, std::nullopt, senses);
  if (constexpr std::string_view owner = "'s"; senses.empty() && form.ends_with(owner)) {
    form.resize(form.size() - owner.size());
    addSenses(form, PartOfSpeech::noun, senses);
  }
  for (const Ending& ending : endings) {
    if (!form.ends_with(ending.from) || form.size() < ending.from.size() + 2 || form.ends_with("ss"))
      continue;
    const std::string stem = form.substr(0, form.size() - ending.from.size());
    addSenses(stem + std::string(ending.to), ending.pos, senses);
    // "stopped": the last consonant was doubled.
    if (ending.pos == PartOfSpeech::verb && ending.to.empty() && stem.size() > 3 &&
        stem.back() == stem[stem.size() - 2])
      addSenses(stem.substr(0, stem.size() - 1), ending.pos, senses);
  }
  float sum = 0;
  for (const Sense& sense : senses) sum += sense.probability;
  for (Sense& sense : senses) sense.probability /= sum;
  std::sort(senses.begin(), senses.end(), [](const Sense& a, const Sense& b) {
    return a.probability != b.probability ? a.probability > b.probability : a.synset < b.synset;
  });
  return senses;
}

std::vector<std::uint32_t> Lexicon::usualNouns(std::string_view asked) const {
  constexpr auto noun = static_cast<std::size_t>(PartOfSpeech::noun);
  std::vector<std::uint32_t> nouns;
  for (const Sense& sense : senses(asked))
    if (sense.probability >= minUsualShare && sense.synset >= firstSynset[noun] &&
        sense.synset < firstSynset[noun + 1])
      nouns.push_back(sense.synset);
  return nouns;
}

bool Lexicon::startsEntry(std::string_view beginning) const {
  const std::size_t at = lowerBound(beginning);
  return at < size() && word(at).starts_with(beginning);
}

std::vector<std::string> Lexicon::terms(std::string_view asked) const {
  const std::vector<std::string> words = splitText(asked);
  std::vector<std::string> terms;
  for (std::size_t i = 0; i < words.size();) {
    std::string term, joined = words[i];
    std::size_t together = 1;
    const bool isFunction = isFunctionWord(words[i]);
    if (joined.size() > 1 && !isFunction) term = joined;
    // Only the last word of a compound is inflected: the others stand at the beginning of an entry.
    const std::size_t most = isFunction ? 1 : std::min(maxTogether, words.size() - i);
    for (std::size_t n = 2; n <= most && startsEntry(joined += ' '); ++n) {
      joined += words[i + n - 1];
      if (!knows(joined)) continue;
      term = joined;
      together = n;
    }
    if (!term.empty()) terms.push_back(std::move(term));
    i += together;
  }
  return terms;
}

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
