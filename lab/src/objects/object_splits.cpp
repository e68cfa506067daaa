// SPDX-License-Identifier: Apache-2.0
#include "objects/object_splits.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "findings/thesis.hpp"
#include "objects/object_splits_data.hpp"
#include "objects/object_splits_results.hpp"

namespace estancia::experiments {
namespace {

constexpr int objectSplitsVersion = 1;  // version of the code below: cells of another one are computed anew

template <class T>
std::vector<T> rowsOf(const std::vector<T>& all, const std::vector<std::size_t>& rows) {
  std::vector<T> some;
  some.reserve(rows.size());
  for (const std::size_t row : rows) some.push_back(all[row]);
  return some;
}

ClassProbabilities rowsOf(const ClassProbabilities& all, const std::vector<std::size_t>& rows) {
  ClassProbabilities some{DescriptorMatrix(all.probabilities.labels()), rowsOf(all.coverage, rows)};
  for (const std::size_t row : rows) some.probabilities.append(all.probabilities.row(row));
  return some;
}

/// The truth in the form of a perfect labeler's answers.
ClassProbabilities truthOf(const ObjectTask& task, const std::vector<std::size_t>& rows) {
  ClassProbabilities truth{DescriptorMatrix(task.targets.classes.size()), std::vector<float>(rows.size(), 1)};
  for (const std::size_t row : rows) {
    std::vector<float> one(task.targets.classes.size());
    one[static_cast<std::size_t>(task.classes[row])] = 1;
    truth.probabilities.append(one);
  }
  return truth;
}

/// The likeliest class; −1 where nothing is labels.
int bestOf(DescriptorView row) {
  const auto best = std::max_element(row.begin(), row.end());
  return best == row.end() || *best <= 0 ? -1 : static_cast<int>(best - row.begin());
}

/// The labeler's classes of these samples; its prior is taken from the training samples, the truth is not
/// used.
std::vector<int> labeled(const ObjectTask& task, const ObjectSplit& split,
                         const std::vector<std::size_t>& samples) {
  ClassProbabilities labels = rowsOf(task.labels->restricted, samples);
  if (task.data->prior) labels = corrected(labels, priorOf(rowsOf(task.labels->restricted, split.train)));
  std::vector<int> classes;
  for (std::size_t i = 0; i < labels.probabilities.size(); ++i)
    classes.push_back(bestOf(labels.probabilities.row(i)));
  return classes;
}

/// One cell: names made, shapes learned, test asked.
struct Trial {
  const ObjectSplitsOptions* options;
  const ObjectTask* task;
  std::size_t split;
  ObjectMethod method;
  double noise;

  std::string inputs() const {
    const ObjectSplit& rows = task->splits[split];
    const ObjectSplitsOptions::Data& data = *task->data;
    return sha256(fmt::format("{} {} {} {} {} {} {} {} {} {} {}", objectSplitsVersion, task->digest,
                              fmt::join(rows.train, ","), fmt::join(rows.test, ","), method.name(), noise,
                              static_cast<int>(data.noise), data.machineNames, data.prior, options->folds,
                              fmt::join(data.trials.seeds, ",")));
  }

  std::vector<int> answer(std::uint64_t seed) const {
    const ObjectSplit& rows = task->splits[split];
    const ObjectSplitsOptions::Data& data = *task->data;
    const auto objects = rowsOf(task->objects, rows.train), groups = rowsOf(task->groups, rows.train);
    ClassifierOptions how;
    how.type = method.classifier;
    how.folds = options->folds;
    how.seed = seed;
    how.threads = 1;  // cells run side by side
    ClassProbabilities labels =
        data.machineNames ? rowsOf(task->labels->restricted, rows.train) : truthOf(*task, rows.train);
    // Other noise in each split; the same for all methods.
    if (noise > 0) labels = withNoise(labels, data.noise, noise, objects, seed * 100'003 + split);
    if (data.prior) labels = corrected(labels, priorOf(labels));
    Progress silent;
    const Features shapes = withRows(task->shapes, rows.train);
    const auto names = assignPseudoLabels(
        method.pseudoLabeling, labels, method.pseudoLabeling == PseudoLabeling::confident ? groups : objects,
        shapes, how, silent);
    // Learns like ObjectModel, without its agreement, which takes five times as long.
    const LabeledShapes labeled =
        labeledShapes(shapes, names, groups, task->targets.classes.size(), options->folds);
    const DescriptorMatrix found =
        trainClassifier(labeled.samples, how, silent)
            ->predict(labeled.embedding.apply(withRows(task->shapes, rows.test)), 1);
    std::vector<int> classes;
    for (std::size_t i = 0; i < found.size(); ++i) classes.push_back(bestOf(found.row(i)));
    return classes;
  }

  CellResults run() const {
    const ObjectSplit& rows = task->splits[split];
    try {
      SceneAnswers answers;
      for (const std::uint64_t seed : task->data->trials.seeds) answers.answers.push_back(answer(seed));
      CellResults results = answers.toResults(testOf(*task, rows));
      if (task->labels) {
        const std::vector<int> names = labeled(*task, rows, rows.test);
        std::size_t right = 0;
        for (std::size_t i = 0; i < names.size(); ++i) right += names[i] == task->classes[rows.test[i]];
        results.push_back(
            {"labeler_accuracy", "", static_cast<double>(right) / static_cast<double>(names.size())});
      }
      return results;
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      throw Error(problem.code(), fmt::format("{}, {}, {}, noise {}: {}", task->data->name, rows.name,
                                              method.name(), noise, problem.what()));
    }
  }
};

ObjectSplitsResults runTask(const ObjectSplitsOptions& options, const ObjectTask& task, Grid& grid,
                            Progress& progress) {
  ObjectSplitsResults results;
  results.task = &task;
  results.thesisTables = options.thesisTables;
  results.methods = methodsOf(task.data->trials);
  std::vector<Trial> trials;
  std::vector<Cell> cells;
  for (const ObjectMethod& method : results.methods)
    for (const double noise : task.data->trials.noises)
      for (std::size_t s = 0; s < task.splits.size(); ++s) {
        trials.push_back({&options, &task, s, method, noise});
        cells.push_back({{task.data->name, task.splits[s].name, method.name(), fmt::format("{}", noise)},
                         trials.back().inputs()});
      }
  const auto found = grid.run(
      cells, [&](std::size_t t) { return trials[t].run(); }, progress, "learning " + task.data->name);
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const SceneTest test = testOf(task, task.splits[trials[t].split]);
    SceneAnswers answers = SceneAnswers::fromResults(found[t], test, task.data->trials.seeds.size());
    results.cells.push_back({answers.accuracy(test), std::move(answers)});
  }
  if (task.labels) {
    for (const ObjectSplit& split : task.splits) results.labeled.push_back(labeled(task, split, split.test));
    results.learnedFrom = labeled(task, task.splits[0], task.splits[0].train);
  }
  return results;
}

void addFacts(const ObjectTask& task, Findings& findings) {
  const ObjectSplitsOptions::Data& data = *task.data;
  std::string told = fmt::format("{} views of {} objects of {} classes; ESF of {} samples{}; names of {}",
                                 task.classes.size(), task.objectNames.size(), task.targets.classes.size(),
                                 data.shape.samples, data.shape.size ? " and size" : "",
                                 data.machineNames ? "the labeler" : "people");
  if (task.labels) told += fmt::format(", labeler {}", task.labels->labeler);
  if (task.labels) told += data.prior ? ", corrected by its prior" : ", as it says";
  if (data.trials.noises.back() > 0)
    told += fmt::format("; noise by {}", data.noise == NoiseKind::view   ? "view"
                                         : data.noise == NoiseKind::pair ? "view, to the next class"
                                                                         : "object");
  told += fmt::format("; seeds {}", fmt::join(data.trials.seeds, ", "));
  findings.facts.emplace_back(data.name, told);
}

}  // namespace

GridColumns objectSplitsColumns() {
  return {{"data", "split", "classifier", "label_noise"},
          "",
          {"labeler_accuracy", "accuracy"},
          {"data", "split", "labeler_accuracy", "classifier", "label_noise", "accuracy"}};
}

Findings splitObjects(const ObjectSplitsOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress) {
  Findings findings;
  findings.title = "Objects that label themselves";
  const std::vector<ObjectTask> tasks = prepareTasks(options, run, progress, findings.notes);
  const bool asked = std::any_of(tasks.begin(), tasks.end(), [](const ObjectTask& t) { return !!t.labels; });
  bool instances = false;
  for (const ObjectTask& task : tasks) {
    const ObjectSplitsResults results = runTask(options, task, grid, progress);
    if (task.labels || !asked) findings.summary += (findings.summary.empty() ? "" : " ") + summaryOf(results);
    addFindings(results, findings);
    addFacts(task, findings);
    instances |= task.data->split == ObjectSplitsOptions::Split::instances;
  }
  if (options.thesisTables && instances)
    findings.sections.emplace_back(readThesisTable(thesisObjectsCsv, 1)
                                       .resultTable({"The thesis, other data",
                                                     "8 objects × 3 instances, 500 samples an object as "
                                                     "printed; AlexNet's words, ESF, SVM (Table 6.2; "
                                                     "6.4.3, 6.4.4, Tables 6.7 and 6.8). Its data was never "
                                                     "published: compare the form, not the numbers.",
                                                     "split",
                                                     {{"labeler [%]", 1}, {"classifier [%]", 2}},
                                                     {}}));
  return findings;
}

}  // namespace estancia::experiments
