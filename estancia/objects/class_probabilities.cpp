// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/class_probabilities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// A class that the labeler never gave may still occur.
constexpr float minPrior = 0.001F;

constexpr std::size_t noClass = ~std::size_t{0};

/// "NAME", or "NAME (is it A, B?)" with the labels that are spelled like one of these.
std::string withSpellings(const Vocabulary& vocabulary, const std::string& name,
                          const std::vector<std::string>& labels) {
  std::vector<std::string> near;
  for (const std::string& label : labels)
    for (const std::string& spelling : findNearSpellings(vocabulary, label))
      if (std::ranges::find(near, spelling) == near.end()) near.push_back(spelling);
  return near.empty() ? name : fmt::format("{} (is it {}?)", name, fmt::join(near, ", "));
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
      unknown.push_back(withSpellings(vocabulary, target.name, target.labels));
    else if (!own)
      taken.push_back(fmt::format("{} (as {})", target.name, targets.classes[other].name));
  }
  if (!unknown.empty())
    fail(ErrorCode::unknownName,
         "the labeler has no label for {} of {} target classes: {}; give them other labels, "
         "leave them out, or use another labeler",
         unknown.size(), targets.classes.size(), fmt::join(unknown, ", "));
  if (!taken.empty())
    fail(ErrorCode::invalidInput,
         "target classes have the labels of others only: {}; give them other labels, or merge "
         "them",
         fmt::join(taken, ", "));
  return classOf;
}

/// Makes the row add up to 1, unless it is all 0.
void normalize(std::vector<float>& row) {
  const double sum = std::accumulate(row.begin(), row.end(), 0.0);
  for (float& p : row) p = sum > 0 ? static_cast<float>(p / sum) : 0;
}

}  // namespace

std::vector<std::string> unknownLabels(const TargetClasses& targets, const Vocabulary& vocabulary) {
  std::vector<std::string> warnings;
  for (const TargetClasses::Class& target : targets.classes) {
    std::vector<std::string> unknown;
    for (const std::string& label : target.labels)
      if (findLabels(vocabulary, label).empty()) unknown.push_back(label);
    if (unknown.size() == target.labels.size()) continue;  // VocabularyMapping refuses it
    for (const std::string& label : unknown)
      warnings.push_back(fmt::format("{}: the labeler has no label {}", target.name,
                                     withSpellings(vocabulary, fmt::format("\"{}\"", label), {label})));
  }
  return warnings;
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
