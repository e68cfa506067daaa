// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/pseudo_labels.hpp"

#include <algorithm>
#include <map>

#include "estancia/core/fail.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/objects/confident_learning.hpp"
#include "estancia/objects/learning.hpp"

namespace estancia {
namespace {

/// −1 without any probability.
int mostProbable(DescriptorView p) {
  const auto best = std::ranges::max_element(p);
  return best == p.end() || !(*best > 0) ? -1 : static_cast<int>(best - p.begin());
}

std::vector<int> bestOfEach(const DescriptorMatrix& p) {
  std::vector<int> classes;
  for (std::size_t i = 0; i < p.size(); ++i) classes.push_back(mostProbable(p.row(i)));
  return classes;
}

void requireAsMany(const ClassProbabilities& answers, std::size_t others, const char* what) {
  if (answers.probabilities.size() != others)
    fail(ErrorCode::mismatch, "{} samples have answers, but {} have {}; give one each",
         answers.probabilities.size(), others, what);
}

/// The samples of each instance, in ascending order.
std::vector<std::vector<std::size_t>> samplesOf(std::span<const int> instances) {
  std::map<int, std::vector<std::size_t>> samples;
  for (std::size_t i = 0; i < instances.size(); ++i) samples[instances[i]].push_back(i);
  std::vector<std::vector<std::size_t>> lists;
  lists.reserve(samples.size());
  for (auto& [instance, list] : samples) lists.push_back(std::move(list));
  return lists;
}

/// The class of each instance by its fused probabilities (one vote per sample); −1 without any.
std::vector<int> poolOf(const ClassProbabilities& answers,
                        const std::vector<std::vector<std::size_t>>& objects) {
  std::vector<int> classes;
  for (const auto& samples : objects) {
    LogOpinionPool pool(answers.probabilities.labels());
    for (const std::size_t i : samples) pool.add(answers.probabilities.row(i));
    const std::vector<double> pooled = pool.pooled();
    classes.push_back(pooled.empty() ? -1
                                     : static_cast<int>(std::ranges::max_element(pooled) - pooled.begin()));
  }
  return classes;
}

std::vector<int> voted(const ClassProbabilities& answers, std::span<const int> instances) {
  const auto objects = samplesOf(instances);
  const std::vector<int> classOf = poolOf(answers, objects);
  std::vector<int> classes(instances.size());
  for (std::size_t t = 0; t < objects.size(); ++t)
    for (const std::size_t i : objects[t]) classes[i] = classOf[t];
  return classes;
}

std::vector<int> confident(const ClassProbabilities& answers, std::span<const int> instances,
                           const Features& shapes, const ClassifierOptions& options, Progress& progress) {
  requireAsMany(answers, shapes.values.size(), "a shape");
  std::vector<int> classes = bestOfEach(answers.probabilities);
  std::vector<int> known = classes;
  std::ranges::sort(known);
  if (known.empty() || std::max(known.front(), 0) >= known.back()) return classes;  // fewer than two classes
  const LabeledShapes labeled =
      labeledShapes(shapes, classes, instances, answers.probabilities.labels(), options.folds);
  for (const std::size_t i :
       likelyMislabeled(labeled.samples.classes, heldOut(labeled.samples, options, progress)))
    classes[labeled.rows[i]] = -1;
  return classes;
}

}  // namespace

Choices pseudoLabelings() {
  return {{"top", "the most probable class of each sample, as in the thesis"},
          {"voted", "one class an instance, from the fused probabilities of all its samples"},
          {"confident", "as top, without samples that the shapes of the others contradict"}};
}

PseudoLabeling getPseudoLabeling(const std::string& name) {
  requireChoice("pseudo-labeling", name, pseudoLabelings());
  return name == "top"     ? PseudoLabeling::top
         : name == "voted" ? PseudoLabeling::voted
                           : PseudoLabeling::confident;
}

std::vector<int> assignPseudoLabels(PseudoLabeling labeling, const ClassProbabilities& answers,
                                    std::span<const int> instances, const Features& shapes,
                                    const ClassifierOptions& options, Progress& progress) {
  requireAsMany(answers, instances.size(), "an instance");
  switch (labeling) {
    case PseudoLabeling::top:
      return bestOfEach(answers.probabilities);
    case PseudoLabeling::voted:
      return voted(answers, instances);
    case PseudoLabeling::confident:
      return confident(answers, instances, shapes, options, progress);
  }
  throw Error(ErrorCode::invalidOption,
              "the pseudo-labeling is none of PseudoLabeling; give one of its values");
}

}  // namespace estancia
