#include "estancia/objects/target_classes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/io/files.hpp"

namespace estancia {
namespace {

/// What a labeler never said is no proof that it never will.
constexpr float leastPrior = 0.001F;

constexpr std::size_t noWord = ~std::size_t{0};

std::vector<std::string> texts(ConfigFile& config, const toml::node& node) {
  std::vector<std::string> all;
  for (const toml::node& element : config.list(node)) all.push_back(config.text(element));
  if (all.empty())
    config.fail(node, fmt::format("`{}` is empty; leave it out where it is the word's name", config.key()));
  return all;
}

TargetClasses::Word readWord(ConfigFile& config, const std::string& name, const toml::node& node) {
  const auto* table = node.as_table();
  if (table == nullptr) config.fail(node, fmt::format("`words.{}` must be a table", name));
  TargetClasses::Word word{name, {name}, {name}};
  config.read(*table, {{"labels", false, "", [&](auto& n) { word.labels = texts(config, n); }},
                       {"categories", false, "", [&](auto& n) { word.categories = texts(config, n); }}});
  return word;
}

/// "NAME", or "NAME (is it A, B?)" with what there is that is spelt like one of these labels.
std::string withSpellings(const Vocabulary& vocabulary, const std::string& name,
                          const std::vector<std::string>& labels) {
  std::vector<std::string> near;
  for (const std::string& label : labels)
    for (const std::string& spelling : findNearSpellings(vocabulary, label))
      if (std::ranges::find(near, spelling) == near.end()) near.push_back(spelling);
  return near.empty() ? name : fmt::format("{} (is it {}?)", name, fmt::join(near, ", "));
}

/// The word of each label; noWord for most.
std::vector<std::size_t> wordsOfLabels(const TargetClasses& study, const Vocabulary& vocabulary) {
  std::vector<std::size_t> wordOf(vocabulary.size(), noWord);
  std::vector<std::string> unknown, taken;
  for (std::size_t w = 0; w < study.words.size(); ++w) {
    const TargetClasses::Word& word = study.words[w];
    bool known = false, own = false;
    std::size_t other = noWord;
    for (const std::string& asked : word.labels)
      for (const std::size_t label : findLabels(vocabulary, asked)) {
        known = true;
        if (wordOf[label] == noWord) wordOf[label] = w;
        own = own || wordOf[label] == w;
        if (wordOf[label] != w) other = wordOf[label];
      }
    if (!known)
      unknown.push_back(withSpellings(vocabulary, word.name, word.labels));
    else if (!own)
      taken.push_back(fmt::format("{} (they count for {})", word.name, study.words[other].name));
  }
  if (unknown.size() == study.words.size())
    throw Error(
        fmt::format("the labeler knows none of the study's words: {}; give them other labels, or take a "
                    "labeler that does",
                    fmt::join(unknown, ", ")));
  if (!unknown.empty())
    throw Error(
        fmt::format("the labeler has no label for {} of the study's {} words: {}; give them other labels, "
                    "or leave them out",
                    unknown.size(), study.words.size(), fmt::join(unknown, ", ")));
  if (!taken.empty())
    throw Error(
        fmt::format("words of the study that have no label of their own: {}; give them other labels, or "
                    "make them one word",
                    fmt::join(taken, ", ")));
  return wordOf;
}

/// Makes the row add up to 1, unless it is all 0.
void scale(std::vector<float>& row) {
  const double sum = std::accumulate(row.begin(), row.end(), 0.0);
  for (float& share : row) share = sum > 0 ? static_cast<float>(share / sum) : 0;
}

}  // namespace

std::string flawOf(const TargetClasses& study) {
  if (study.words.empty()) return "a study needs at least one word";
  std::set<std::string> names;
  std::set<std::pair<std::string, std::string>> owners;  // of categories
  for (const TargetClasses::Word& word : study.words) {
    if (word.name.empty()) return "a word of the study has no name";
    if (word.labels.empty()) return fmt::format("\"{}\" has no label", word.name);
    for (const auto* texts : {&word.labels, &word.categories})
      for (const std::string& text : *texts)
        if (text.empty() || io::printable(text) != text)
          return fmt::format("\"{}\" has a label or category that is empty or holds control characters",
                             io::printable(word.name));
    if (io::printable(word.name) != word.name)
      return fmt::format("the word \"{}\" holds control characters", io::printable(word.name));
    if (!names.insert(word.name).second) return fmt::format("two words are called \"{}\"", word.name);
    for (const std::string& category : word.categories) {
      const auto found = owners.lower_bound({category, ""});
      if (found != owners.end() && found->first == category && found->second != word.name)
        return fmt::format("the category \"{}\" belongs to both \"{}\" and \"{}\"", category, found->second,
                           word.name);
      owners.emplace(category, word.name);
    }
  }
  return "";
}

TargetClasses TargetClasses::fromFile(const std::filesystem::path& file) {
  ConfigFile config(file);
  const toml::table* words = nullptr;
  config.read({{"words", true, "a table [words.NAME] for each word of the study",
                [&](auto& n) { words = &config.subtable(n); }}});
  // The parser sorts by name; the order of the file is the one that people wrote.
  std::vector<std::pair<std::string, const toml::node*>> inOrder;
  for (const auto& [name, node] : *words) inOrder.emplace_back(name.str(), &node);
  std::ranges::stable_sort(inOrder, {}, [](const auto& entry) {
    const auto& begin = entry.second->source().begin;
    return std::pair(begin.line, begin.column);
  });
  TargetClasses study;
  for (const auto& [name, node] : inOrder) {
    study.words.push_back(readWord(config, name, *node));
    if (const std::string flaw = flawOf(study); !flaw.empty()) config.fail(*node, flaw);
  }
  if (study.words.empty()) config.fail(*words, flawOf(study));
  return study;
}

TargetClasses TargetClasses::ofCategories(const std::vector<std::string>& categories) {
  TargetClasses study;
  for (const std::string& category : categories)
    if (study.wordOf(category) < 0) study.words.push_back({category, {category}, {category}});
  if (const std::string flaw = flawOf(study); !flaw.empty()) throw Error(flaw);
  return study;
}

std::vector<std::string> TargetClasses::names() const {
  std::vector<std::string> all;
  for (const Word& word : words) all.push_back(word.name);
  return all;
}

int TargetClasses::wordOf(const std::string& category) const {
  for (std::size_t w = 0; w < words.size(); ++w)
    if (std::ranges::find(words[w].categories, category) != words[w].categories.end())
      return static_cast<int>(w);
  return -1;
}

std::vector<std::string> unknownLabels(const TargetClasses& study, const Vocabulary& vocabulary) {
  std::vector<std::string> sentences;
  for (const TargetClasses::Word& word : study.words) {
    std::vector<std::string> unknown;
    for (const std::string& label : word.labels)
      if (findLabels(vocabulary, label).empty()) unknown.push_back(label);
    if (unknown.size() == word.labels.size()) continue;  // Restriction refuses it
    for (const std::string& label : unknown)
      sentences.push_back(fmt::format("{}: the labeler has no label {}", word.name,
                                      withSpellings(vocabulary, fmt::format("\"{}\"", label), {label})));
  }
  return sentences;
}

VocabularyMapping::VocabularyMapping(const TargetClasses& study, const Vocabulary& vocabulary)
    : words_(study.words.size()), wordOf_(wordsOfLabels(study, vocabulary)) {}

ClassProbabilities VocabularyMapping::apply(const DescriptorMatrix& descriptors) const {
  ClassProbabilities result{DescriptorMatrix(words_), {}};
  result.shares.reserve(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const DescriptorView all = descriptors.row(i);
    requireProbabilities(all, wordOf_.size(), fmt::format("sample {}", i));
    std::vector<float> row(words_);
    double whole = 0, mass = 0;
    for (std::size_t label = 0; label < all.size(); ++label) {
      const float p = std::max(all[label], 0.0F);
      whole += p;
      if (wordOf_[label] == noWord) continue;
      row[wordOf_[label]] += p;
      mass += p;
    }
    scale(row);
    result.shares.append(row);
    // What several models say adds up to more than 1.
    result.mass.push_back(static_cast<float>(mass / std::max(whole, 1.0)));
  }
  return result;
}

ClassProbabilities restrictTo(const TargetClasses& study, const Vocabulary& vocabulary,
                              const DescriptorMatrix& descriptors) {
  return VocabularyMapping(study, vocabulary).apply(descriptors);
}

std::vector<float> priorOf(const ClassProbabilities& shares) {
  const std::size_t words = shares.shares.labels();
  std::vector<double> sums(words, 0);
  for (std::size_t i = 0; i < shares.shares.size(); ++i)
    for (std::size_t w = 0; w < words; ++w) sums[w] += shares.shares.row(i)[w];
  std::vector<float> prior(sums.begin(), sums.end());
  scale(prior);
  if (std::ranges::all_of(prior, [](float p) { return p == 0; }))
    std::ranges::fill(prior, words == 0 ? 0 : 1 / static_cast<float>(words));
  return prior;
}

ClassProbabilities corrected(const ClassProbabilities& shares, std::span<const float> prior) {
  if (prior.size() != shares.shares.labels())
    throw Error(
        fmt::format("a prior of {} words cannot correct shares of {}", prior.size(), shares.shares.labels()));
  requireProbabilities(prior, prior.size(), "the prior");
  ClassProbabilities result{DescriptorMatrix(prior.size()), shares.mass};
  result.shares.reserve(shares.shares.size());
  std::vector<float> row(prior.size());
  for (std::size_t i = 0; i < shares.shares.size(); ++i) {
    for (std::size_t w = 0; w < row.size(); ++w)
      row[w] = shares.shares.row(i)[w] / std::max(prior[w], leastPrior);
    scale(row);
    result.shares.append(row);
  }
  return result;
}

}  // namespace estancia
