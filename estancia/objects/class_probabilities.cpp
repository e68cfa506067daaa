// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/class_probabilities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/words/label_search.hpp"

namespace estancia {
namespace {

/// A class that the labeler never gave may still occur.
constexpr float minPrior = 0.001F;

constexpr std::size_t noClass = ~std::size_t{0};

/// "NAME", or "NAME (is it A, B?)" with the labels that are spelled like one of these, or related to it.
std::string withNearLabels(const Vocabulary& vocabulary, const std::string& name,
                           const std::vector<std::string>& labels, WordGraphSource source) {
  constexpr std::size_t maxRelated = 3;
  std::vector<std::string> near;
  const auto add = [&near](const std::string& label) {
    if (std::ranges::find(near, label) == near.end()) near.push_back(label);
  };
  for (const std::string& label : labels) {
    for (const std::string& spelling : findNearSpellings(vocabulary, label)) add(spelling);
    if (source == nullptr) continue;
    const LabelMatches related = findLabelMatches(vocabulary, label, source);
    for (std::size_t i = 0; i < std::min(maxRelated, related.labels.size()); ++i)
      add(shortLabel(vocabulary[related.labels[i].label]));
  }
  return near.empty() ? name : fmt::format("{} (is it {}?)", name, fmt::join(near, ", "));
}

[[noreturn]] void failUnknown(const std::vector<std::string>& unknown, const TargetClasses& targets) {
  fail(ErrorCode::unknownName,
       "the labeler has no label for {} of {} target classes: {}; give them other labels, leave them out, or "
       "use another labeler",
       unknown.size(), targets.classes.size(), fmt::join(unknown, ", "));
}

/// A class that no label has the name of, and the labels that are kinds of it.
struct UnnamedClass {
  std::size_t number = 0;
  std::vector<LabelMatch> kinds = {};
};

std::vector<UnnamedClass> unnamedClasses(const TargetClasses& targets, const Vocabulary& vocabulary,
                                         WordGraphSource source, std::set<std::size_t>& named) {
  std::vector<UnnamedClass> unnamed;
  for (std::size_t c = 0; c < targets.classes.size(); ++c) {
    bool known = false;
    for (const std::string& asked : targets.classes[c].labels)
      for (const std::size_t label : findLabels(vocabulary, asked)) {
        known = true;
        named.insert(label);
      }
    if (known) continue;
    UnnamedClass& own = unnamed.emplace_back(UnnamedClass{c});
    const WordGraph* graph = source == nullptr ? nullptr : source();
    for (const std::string& asked : targets.classes[c].labels)
      if (graph != nullptr)
        for (LabelMatch& kind : findLabelKinds(vocabulary, *graph, asked))
          own.kinds.push_back(std::move(kind));
  }
  std::ranges::stable_sort(unnamed, {}, [](const UnnamedClass& one) { return one.kinds.size(); });
  return unnamed;
}

/// The class of each label; noClass for most.
std::vector<std::size_t> classesOfLabels(const TargetClasses& targets, const Vocabulary& vocabulary) {
  std::vector<std::size_t> classOf(vocabulary.size(), noClass);
  std::vector<std::string> unknown, taken;
  for (std::size_t c = 0; c < targets.classes.size(); ++c) {
    const TargetClasses::Class& target = targets.classes[c];
    bool known = false, own = false;
    std::size_t other = noClass;
    for (const std::string& asked : target.labels)
      for (const std::size_t label : findLabels(vocabulary, asked)) {
        known = true;
        if (classOf[label] == noClass) classOf[label] = c;
        own = own || classOf[label] == c;
        if (classOf[label] != c) other = classOf[label];
      }
    if (!known)
      unknown.push_back(withNearLabels(vocabulary, target.name, target.labels, nullptr));
    else if (!own)
      taken.push_back(fmt::format("{} (as {})", target.name, targets.classes[other].name));
  }
  if (!unknown.empty()) failUnknown(unknown, targets);
  if (!taken.empty())
    fail(ErrorCode::invalidInput,
         "target classes have the labels of others only: {}; give them other labels, or merge them",
         fmt::join(taken, ", "));
  return classOf;
}

/// Makes the row add up to 1, unless it is all 0.
void normalize(std::vector<float>& row) {
  const double sum = std::accumulate(row.begin(), row.end(), 0.0);
  for (float& p : row) p = sum > 0 ? static_cast<float>(p / sum) : 0;
}

}  // namespace

std::vector<std::string> unknownLabels(const TargetClasses& targets, const Vocabulary& vocabulary,
                                       WordGraphSource source) {
  std::vector<std::string> warnings;
  for (const TargetClasses::Class& target : targets.classes) {
    std::vector<std::string> unknown;
    for (const std::string& label : target.labels)
      if (findLabels(vocabulary, label).empty()) unknown.push_back(label);
    if (unknown.size() == target.labels.size()) continue;  // VocabularyMapping refuses it
    for (const std::string& label : unknown)
      warnings.push_back(
          fmt::format("{}: the labeler has no label {}", target.name,
                      withNearLabels(vocabulary, fmt::format("\"{}\"", label), {label}, source)));
  }
  return warnings;
}

TargetClasses withLabelKinds(const TargetClasses& targets, const Vocabulary& vocabulary,
                             WordGraphSource source, std::vector<std::string>* told) {
  TargetClasses understood = targets;
  std::set<std::size_t> taken;
  std::vector<std::string> unknown;
  for (const UnnamedClass& unnamed : unnamedClasses(targets, vocabulary, source, taken)) {
    TargetClasses::Class& target = understood.classes[unnamed.number];
    std::vector<std::string> reasons;
    for (const LabelMatch& kind : unnamed.kinds) {
      const std::string label = shortLabel(vocabulary[kind.label]);
      // A name that two labels have, such as "crane", would mean both.
      if (labelsNamed(vocabulary, label) != std::vector{kind.label} || !taken.insert(kind.label).second)
        continue;
      target.labels.push_back(label);
      reasons.push_back(fmt::format("{} ({})", label, kind.reason));
    }
    if (reasons.empty())
      unknown.push_back(withNearLabels(vocabulary, target.name, target.labels, source));
    else if (told != nullptr)
      told->push_back(fmt::format("{}: the labeler has no label of that name; taken: {}", target.name,
                                  fmt::join(reasons, ", ")));
  }
  if (!unknown.empty()) failUnknown(unknown, targets);
  return understood;
}

VocabularyMapping::VocabularyMapping(const TargetClasses& targets, const Vocabulary& vocabulary)
    : classes_(targets.classes.size()), classOf_(classesOfLabels(targets, vocabulary)) {}

ClassProbabilities VocabularyMapping::apply(const DescriptorMatrix& descriptors) const {
  ClassProbabilities result{DescriptorMatrix(classes_), {}};
  result.probabilities.reserve(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const DescriptorView all = descriptors.row(i);
    requireProbabilities(all, classOf_.size(), fmt::format("sample {}", i));
    std::vector<float> row(classes_);
    double whole = 0, covered = 0;
    for (std::size_t label = 0; label < all.size(); ++label) {
      const float p = std::max(all[label], 0.0F);
      whole += p;
      if (classOf_[label] == noClass) continue;
      row[classOf_[label]] += p;
      covered += p;
    }
    normalize(row);
    result.probabilities.append(row);
    // The answers of several models add up to more than 1.
    result.coverage.push_back(static_cast<float>(covered / std::max(whole, 1.0)));
  }
  return result;
}

ClassProbabilities restrictTo(const TargetClasses& targets, const Vocabulary& vocabulary,
                              const DescriptorMatrix& descriptors) {
  return VocabularyMapping(targets, vocabulary).apply(descriptors);
}

std::vector<float> priorOf(const ClassProbabilities& answers) {
  const DescriptorMatrix& p = answers.probabilities;
  std::vector<double> sums(p.labels(), 0);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += p.row(i)[c];
  std::vector<float> prior(sums.begin(), sums.end());
  normalize(prior);
  if (std::ranges::all_of(prior, [](float share) { return share == 0; }))
    std::ranges::fill(prior, prior.empty() ? 0 : 1 / static_cast<float>(prior.size()));
  return prior;
}

ClassProbabilities corrected(const ClassProbabilities& answers, std::span<const float> prior) {
  const DescriptorMatrix& p = answers.probabilities;
  if (prior.size() != p.labels())
    fail(ErrorCode::mismatch, "the prior has {} classes, the probabilities {}; give as many of each",
         prior.size(), p.labels());
  requireProbabilities(prior, prior.size(), "the prior");
  ClassProbabilities result{DescriptorMatrix(prior.size()), answers.coverage};
  result.probabilities.reserve(p.size());
  std::vector<float> row(prior.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = p.row(i)[c] / std::max(prior[c], minPrior);
    normalize(row);
    result.probabilities.append(row);
  }
  return result;
}

}  // namespace estancia
