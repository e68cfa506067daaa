// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/own_classes.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia {
namespace {

/// The views of an object.
struct PooledObject {
  std::vector<float> sums;
  std::size_t views = 0;
};

std::map<int, PooledObject> poolObjects(const DescriptorMatrix& labels, const std::vector<int>& instances) {
  std::map<int, PooledObject> objects;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    PooledObject& object = objects[instances[i]];
    object.sums.resize(labels.labels());
    ++object.views;
    for (std::size_t l = 0; l < labels.labels(); ++l) object.sums[l] += labels.row(i)[l];
  }
  return objects;
}

/// The words that the labels of all objects are, each object counting the same.
std::vector<SureWord> wordsOf(const std::map<int, PooledObject>& objects, const Vocabulary& vocabulary,
                              const LabelConcepts& concepts) {
  std::vector<float> mean(vocabulary.size());
  for (const auto& [instance, object] : objects)
    for (std::size_t l = 0; l < mean.size(); ++l)
      mean[l] += object.sums[l] / static_cast<float>(object.views * objects.size());
  std::vector<SureWord> words;
  for (FamiliarWord& word : familiarWords(vocabulary, concepts, mean, mean.size()))
    words.push_back({std::move(word.name), std::move(word.labels)});
  return words;
}

/// Index in `words` of what each object surely has; −1: none. Counts the objects in `words`.
std::map<int, int> sureWordsOf(const std::map<int, PooledObject>& objects, double minProbability,
                               std::vector<SureWord>& words) {
  std::map<int, int> wordOf;
  for (const auto& [instance, object] : objects) {
    const auto probability = [&object = object](const SureWord& word) {
      double sum = 0;
      for (const std::size_t label : word.labels) sum += static_cast<double>(object.sums[label]);
      return sum / static_cast<double>(object.views);
    };
    const auto word = std::ranges::max_element(words, {}, probability);
    const double p = word == words.end() ? 0 : probability(*word);
    wordOf[instance] = p > minProbability ? static_cast<int>(word - words.begin()) : -1;
    if (p <= minProbability) continue;
    ++word->objects;
    word->views += object.views;
    word->probability += p;
  }
  for (SureWord& word : words)
    word.probability /= static_cast<double>(std::max<std::size_t>(word.objects, 1));
  return wordOf;
}

/// The class of each object by its shapes, held out; −1 where other objects do not have its class.
std::map<int, int> heldOutClasses(const LabeledShapes& labeled, const ClassifierOptions& options,
                                  const std::vector<int>& instances, Progress& progress) {
  const DescriptorMatrix found = heldOut(labeled.samples, options, progress);
  std::map<int, std::vector<double>> sums;
  for (std::size_t i = 0; i < found.size(); ++i) {
    std::vector<double>& sum = sums[instances[labeled.rows[i]]];
    sum.resize(found.labels());
    for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += static_cast<double>(found.row(i)[c]);
  }
  std::map<int, int> classes;
  for (const auto& [instance, sum] : sums) {
    const auto best = std::ranges::max_element(sum);
    classes[instance] = *best > 0 ? static_cast<int>(best - sum.begin()) : -1;
  }
  return classes;
}

/// Probability that two sets of `a` and `b` of `all` have `common` or more in common (Fisher's exact test).
double chanceOf(std::size_t common, std::size_t a, std::size_t b, std::size_t all) {
  const auto logOfWays = [](std::size_t n, std::size_t k) {  // to choose k of n
    return std::lgamma(static_cast<double>(n + 1)) - std::lgamma(static_cast<double>(k + 1)) -
           std::lgamma(static_cast<double>(n - k + 1));
  };
  double sum = 0;
  for (std::size_t k = common; k <= std::min(a, b); ++k)
    if (b - k <= all - a) sum += std::exp(logOfWays(a, k) + logOfWays(all - a, b - k) - logOfWays(all, b));
  return std::min(sum, 1.0);
}

/// Compares the words with the shapes of their objects; `classes` has an index in `words` for each sample.
void askShapes(const Features& shapes, const std::vector<int>& classes, const std::vector<int>& instances,
               const ClassifierOptions& options, Progress& progress, std::vector<SureWord>& words) {
  const LabeledShapes labeled = labeledShapes(shapes, classes, instances, words.size(), options.folds);
  const std::map<int, int> byShape = heldOutClasses(labeled, options, instances, progress);
  std::vector<std::size_t> answers(words.size());
  for (const auto& [instance, answer] : byShape)
    if (answer >= 0) ++answers[static_cast<std::size_t>(answer)];
  std::map<int, int> byImage;
  for (std::size_t i = 0; i < classes.size(); ++i)
    if (classes[i] >= 0) byImage[instances[i]] = classes[i];
  for (const auto& [instance, word] : byImage)
    words[static_cast<std::size_t>(word)].recognized += byShape.at(instance) == word ? 1 : 0;
  for (std::size_t w = 0; w < words.size(); ++w)
    words[w].chance = chanceOf(words[w].recognized, words[w].objects, answers[w], byImage.size());
}

/// The largest chance at which words are taken: of these at most 5 % are expected to agree by chance.
double largestDiscovery(const std::vector<SureWord>& words) {
  std::vector<double> chances;
  for (const SureWord& word : words) chances.push_back(word.chance);
  std::ranges::sort(chances);
  double limit = 0;
  for (std::size_t k = 0; k < chances.size(); ++k)
    if (chances[k] <= 0.05 * (1 + 1e-9) * static_cast<double>(k + 1) / static_cast<double>(chances.size()))
      limit = chances[k];  // but for rounding
  return limit;
}

}  // namespace

OwnClasses findOwnClasses(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                          const DescriptorMatrix& labels, const std::vector<int>& instances,
                          const Features& shapes, const ClassifierOptions& options, double minProbability,
                          Progress& progress) {
  if (labels.size() != instances.size() || labels.labels() != vocabulary.size())
    fail(ErrorCode::mismatch, "{} answers of {} labels, for {} samples and a vocabulary of {}", labels.size(),
         labels.labels(), instances.size(), vocabulary.size());
  const std::map<int, PooledObject> objects = poolObjects(labels, instances);
  std::vector<SureWord> words = wordsOf(objects, vocabulary, concepts);
  const std::map<int, int> wordOf = sureWordsOf(objects, std::max(0.5, minProbability), words);
  OwnClasses own;
  own.unsure = static_cast<std::size_t>(
      std::ranges::count_if(wordOf, [](const auto& object) { return object.second < 0; }));
  std::vector<SureWord> candidates;
  std::vector<int> numbers;  // in `candidates`, one a word
  for (const SureWord& word : words) {
    numbers.push_back(word.objects > 1 ? static_cast<int>(candidates.size()) : -1);
    if (word.objects > 1) candidates.push_back(word);
    if (word.objects == 1) own.leftOut.push_back(word);
  }
  std::vector<int> classes;
  for (const int instance : instances) {
    const int word = wordOf.at(instance);
    classes.push_back(word < 0 ? -1 : numbers[static_cast<std::size_t>(word)]);
  }
  if (candidates.size() > 1) askShapes(shapes, classes, instances, options, progress, candidates);
  const double limit = largestDiscovery(candidates);
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t w) { return candidates[w].objects; });
  std::ranges::fill(numbers, -1);
  for (const std::size_t w : order) {
    const bool agrees = candidates[w].chance <= limit;
    if (agrees) numbers[w] = static_cast<int>(own.classes.size());
    (agrees ? own.classes : own.leftOut).push_back(candidates[w]);
  }
  for (const int candidate : classes)
    own.classOf.push_back(candidate < 0 ? -1 : numbers[static_cast<std::size_t>(candidate)]);
  return own;
}

TargetClasses targetClassesOf(const OwnClasses& own, const Vocabulary& vocabulary) {
  TargetClasses targets;
  for (const SureWord& word : own.classes) {
    TargetClasses::Class target{word.name, {}, {}};
    for (const std::size_t label : word.labels) target.labels.push_back(shortLabel(vocabulary[label]));
    if (targets.classOf(word.name) < 0) target.categories.push_back(word.name);
    for (const std::string& name : target.labels)
      if (name != word.name && targets.classOf(name) < 0) target.categories.push_back(name);
    targets.classes.push_back(std::move(target));
  }
  return targets;
}

std::string leftOutOf(const OwnClasses& own) {
  std::vector<std::string> rare, unlike;
  for (const SureWord& word : own.leftOut)
    if (word.objects == 1)
      rare.push_back(word.name);
    else
      unlike.push_back(fmt::format("{} ({} of {})", word.name, word.recognized, word.objects));
  const auto shown = static_cast<std::ptrdiff_t>(std::min<std::size_t>(rare.size(), 10));
  std::string text = fmt::format("{} objects have no sure word", own.unsure);
  if (!rare.empty())
    text +=
        fmt::format("; too rare, one object each: {}{}", fmt::join(rare.begin(), rare.begin() + shown, ", "),
                    rare.size() > 10 ? fmt::format(" and {} more", rare.size() - 10) : "");
  if (!unlike.empty())
    text += fmt::format("; objects not recognized by shape more often than by chance: {}",
                        fmt::join(unlike, ", "));
  return text;
}

}  // namespace estancia
