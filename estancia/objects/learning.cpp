// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/learning.hpp"

#include <set>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// A search in each fold takes five times as long. With a mean squared norm of 1, these values are as
/// accurate as searched ones: 76.7 and 76.3 % of unseen views of 20 restaurant objects.
ClassifierOptions withoutSearch(ClassifierOptions options) {
  if (!options.c) options.c = 10;
  if (!options.gamma) options.gamma = 1;
  return options;
}

}  // namespace

LabeledShapes labeledShapes(const Features& shapes, std::span<const int> classes,
                            std::span<const int> instances, std::size_t count, int folds) {
  const std::size_t n = shapes.values.size();
  if (classes.size() != n || instances.size() != n)
    fail(ErrorCode::mismatch, "{} shapes have {} classes and {} instances; give one of each a shape", n,
         classes.size(), instances.size());
  LabeledShapes labeled{
      .rows = {}, .embedding = {}, .samples = {DescriptorMatrix(0), {}, {}, static_cast<int>(count)}};
  std::vector<int> kept;  // kept instances
  for (std::size_t i = 0; i < n; ++i) {
    if (classes[i] == -1) continue;
    if (classes[i] < 0 || static_cast<std::size_t>(classes[i]) >= count)
      fail(ErrorCode::invalidInput, "shape {} has class {}; give −1 to {}", i, classes[i], count - 1);
    labeled.rows.push_back(i);
    labeled.samples.classes.push_back(classes[i]);
    kept.push_back(instances[i]);
  }
  const Features some = withRows(shapes, labeled.rows);
  labeled.embedding = FeatureEmbedding::learn(some);
  labeled.samples.x = labeled.embedding.apply(some);
  labeled.samples.groups = instanceGroups(labeled.samples.classes, kept, folds);
  return labeled;
}

DescriptorMatrix heldOut(const Samples& samples, const ClassifierOptions& given, Progress& progress) {
  const ClassifierOptions options = withoutSearch(given);
  const std::size_t n = samples.classes.size();
  const std::vector<int> folds = groupedFolds(samples.classes, samples.groups, options.folds, options.seed);
  std::vector<std::vector<float>> answers(n);
  progress.begin("predicting held-out samples", static_cast<std::size_t>(options.folds));
  for (int fold = 0; fold < options.folds; ++fold) {
    std::vector<std::size_t> inside, others;
    std::set<int> known;
    for (std::size_t i = 0; i < n; ++i)
      if (folds[i] != fold) {
        others.push_back(i);
        known.insert(samples.classes[i]);
      }
    for (std::size_t i = 0; i < n; ++i)
      if (folds[i] == fold && known.contains(samples.classes[i])) inside.push_back(i);
    progress.advance();
    if (inside.empty() || known.size() < 2) continue;
    Samples rest{rowsOf(samples.x, others), {}, {}, samples.classCount};
    for (const std::size_t i : others) {
      rest.classes.push_back(samples.classes[i]);
      rest.groups.push_back(samples.groups[i]);
    }
    const DescriptorMatrix p =
        trainClassifier(rest, options)->predict(rowsOf(samples.x, inside), options.threads);
    for (std::size_t k = 0; k < inside.size(); ++k)
      answers[inside[k]].assign(p.row(k).begin(), p.row(k).end());
  }
  progress.end();
  DescriptorMatrix probabilities(static_cast<std::size_t>(samples.classCount));
  probabilities.reserve(n);
  for (std::vector<float>& answer : answers) {
    answer.resize(probabilities.labels());
    probabilities.append(answer);
  }
  return probabilities;
}

}  // namespace estancia
