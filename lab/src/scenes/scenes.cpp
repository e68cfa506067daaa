// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "estancia/classify/label_selection.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "scenes/scene_answers.hpp"
#include "scenes/scenes_data.hpp"
#include "scenes/scenes_findings.hpp"
#include "scenes/scenes_statistics.hpp"

namespace estancia::experiments {
namespace {

constexpr int scenesVersion = 2;  // version of the code below: cells of another one are computed anew

/// The images of each pair as numbers.
void numberTests(const ScenesData& data, ScenesResults& results) {
  std::set<std::string> rooms;
  for (const SceneImages& images : data.images)
    for (const Frame& frame : images.features.frames) rooms.insert(frame.room);
  results.rooms.assign(rooms.begin(), rooms.end());
  for (const ScenesData::Pair& pair : data.pairs) {
    const SceneImages &train = data.images[pair.train], &test = data.images[pair.test];
    ScenesResults::Pair numbered{
        train.name, test.name, {}, {}, {}, train.runs.size(), pair.train == pair.test};
    std::map<std::string, int> runs;
    for (std::size_t i = 0; i < test.runs.size(); ++i) {
      const Frame& frame = test.features.frames[i];
      numbered.names.push_back(frame.name);
      numbered.images.rooms.push_back(static_cast<int>(
          std::lower_bound(results.rooms.begin(), results.rooms.end(), frame.room) - results.rooms.begin()));
      const auto [run, isNew] = runs.emplace(test.runs[i], static_cast<int>(runs.size()));
      if (isNew) numbered.runs.push_back(test.runs[i]);
      numbered.images.runs.push_back(run->second);
    }
    numbered.images.roomCount = static_cast<int>(results.rooms.size());
    numbered.images.runCount = static_cast<int>(runs.size());
    results.pairs.push_back(std::move(numbered));
  }
}

/// Notes which tested rooms are not learned.
void noteUnlearned(const ScenesData& data, std::vector<std::string>& notes) {
  for (const ScenesData::Pair& pair : data.pairs) {
    const SceneImages &train = data.images[pair.train], &test = data.images[pair.test];
    std::set<std::string> learned;
    for (const Frame& frame : train.features.frames) learned.insert(frame.room);
    std::map<std::string, std::size_t> unlearned;
    for (const Frame& frame : test.features.frames)
      if (!learned.contains(frame.room)) ++unlearned[frame.room];
    for (const auto& [room, images] : unlearned)
      notes.push_back(
          fmt::format("{} → {}: {} is asked about but never learned: {} images that all count as wrong",
                      train.name, test.name, room, images));
  }
}

/// One classifier, learned and asked. The number of threads is the grid's: cells run side by side.
struct Trial {
  const ScenesData* data;
  const ScenesResults* results;
  std::size_t pair;
  const SceneDescriptor* descriptor;
  std::string classifier;
  const ScenesOptions* options;
  std::string rule;       // rule for a subset of labels; "": all
  std::size_t count = 0;  // number of labels

  std::string inputs() const {
    const auto& [train, test] = data->pairs[pair];
    return sha256(fmt::format("{} {} {} {} {} {} {} {} {}", scenesVersion,
                              data->images[train].digest(descriptor->parts),
                              data->images[test].digest(descriptor->parts), classifier, options->folds,
                              fmt::join(options->seeds, ","), fmt::join(results->rooms, "\n"), rule, count));
  }

  SceneAnswers answer() const {
    const ScenesData::Pair& images = data->pairs[pair];
    Features train = withParts(data->images[images.train].features, descriptor->parts);
    Features test = withParts(data->images[images.test].features, descriptor->parts);
    if (count > 0) {
      const auto labels = selectColumns(train, rule, count);  // the test is not used
      train = withColumns(train, labels);
      test = withColumns(test, labels);
    }
    SceneAnswers answers;
    for (const std::uint64_t seed : options->seeds) {
      ClassifierOptions how;
      how.type = classifier;
      how.folds = options->folds;
      how.seed = seed;
      how.threads = 1;
      Progress silent;
      const RoomClassifier learned = trainRoomClassifier(train, how, silent);
      auto& rooms = answers.answers.emplace_back();
      for (const std::string& room : mostProbable(learned.rooms(), learned.predict(test, 1)))
        rooms.push_back(static_cast<int>(
            std::lower_bound(results->rooms.begin(), results->rooms.end(), room) - results->rooms.begin()));
    }
    return answers;
  }
};

std::vector<SceneAnswers> runTrials(const std::vector<Trial>& trials, const std::vector<Cell>& cells,
                                    Grid& grid, Progress& progress, const std::string& what) {
  const auto test = [&](std::size_t t) -> const SceneTest& {
    return trials[t].results->pairs[trials[t].pair].images;
  };
  const auto found = grid.run(
      cells, [&](std::size_t t) { return trials[t].answer().toResults(test(t)); }, progress, what);
  std::vector<SceneAnswers> answers;
  for (std::size_t t = 0; t < trials.size(); ++t)
    answers.push_back(SceneAnswers::fromResults(found[t], test(t), trials[t].options->seeds.size()));
  return answers;
}

void runGrid(const ScenesOptions& options, const ScenesData& data, Grid& grid, Progress& progress,
             ScenesResults& results) {
  std::vector<Trial> trials;
  std::vector<Cell> cells;
  for (std::size_t p = 0; p < data.pairs.size(); ++p)
    for (const SceneDescriptor& descriptor : data.descriptors)
      for (const std::string& classifier : results.classifiers) {
        trials.push_back({&data, &results, p, &descriptor, classifier, &options, "", 0});
        cells.push_back({{descriptor.name, classifier, results.pairs[p].train, results.pairs[p].test},
                         trials.back().inputs()});
      }
  results.cells = runTrials(trials, cells, grid, progress, "classifying rooms");
}

/// The curves of Fig. 3.11, in a table of their own.
void runSubsets(const ScenesOptions& options, const ScenesData& data, const ExperimentRun& run,
                Progress& progress, std::vector<std::string>& notes, ScenesResults& results) {
  const auto& subsets = *options.subsets;
  const auto descriptor =
      std::find_if(data.descriptors.begin(), data.descriptors.end(),
                   [&](const SceneDescriptor& known) { return known.name == subsets.descriptor; });
  if (descriptor == data.descriptors.end()) {
    notes.push_back(fmt::format("subsets: the descriptor {} is not compared here, so there is no curve",
                                subsets.descriptor));
    return;
  }
  const std::size_t labels =
      withParts(withRows(data.images[0].features, {}), descriptor->parts).values.labels();
  std::vector<std::size_t> more;
  for (const std::size_t count : subsets.counts)
    if (count > labels)
      more.push_back(count);
    else if (const std::size_t asked = count == 0 ? labels : count;
             results.counts.empty() || results.counts.back() != asked)
      results.counts.push_back(asked);
  if (!more.empty())
    notes.push_back(fmt::format("subsets: {} has {} labels; asked for {}, which was left out",
                                subsets.descriptor, labels, fmt::join(more, ", ")));
  if (results.counts.empty()) return;
  results.labels = labels;
  results.curveDescriptor = descriptor->name;
  results.curveClassifier = subsets.classifier;

  Grid grid(run.folder,
            {{"descriptor", "classifier", "train", "test", "by", "labels"}, "", scenesColumns().measures},
            run.labeler.threads, run.distribution);
  std::vector<Trial> trials;
  std::vector<Cell> cells;
  for (const std::string& rule : subsets.by)
    for (const std::size_t count : results.counts)
      for (std::size_t p = 0; p < data.pairs.size(); ++p) {
        trials.push_back({&data, &results, p, &*descriptor, subsets.classifier, &options,
                          count == labels ? "" : rule, count == labels ? 0 : count});
        cells.push_back({{descriptor->name, subsets.classifier, results.pairs[p].train, results.pairs[p].test,
                          rule, std::to_string(count)},
                         trials.back().inputs()});
      }
  const auto answers = runTrials(trials, cells, grid, progress, "choosing labels");
  std::size_t next = 0;
  for (const std::string& rule : subsets.by) {
    auto& curve = results.curves.emplace_back(ScenesResults::Curve{rule, {}});
    for (std::size_t k = 0; k < results.counts.size(); ++k, next += data.pairs.size())
      curve.answers.emplace_back(answers.begin() + static_cast<std::ptrdiff_t>(next),
                                 answers.begin() + static_cast<std::ptrdiff_t>(next + data.pairs.size()));
  }
  grid.writeCsv(options.name + "-subsets.csv");
}

}  // namespace

GridColumns scenesColumns() {
  return {{"descriptor", "classifier", "train", "test"},
          "",
          {"accuracy", "balanced_accuracy", "accuracy_low", "accuracy_high"}};
}

Findings compareScenes(const ScenesOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress) {
  std::vector<std::string> notes;
  const ScenesData data = describeScenes(options, run, progress, notes);
  ScenesResults results;
  results.name = options.name;
  results.thesisTables = options.thesisTables;
  results.focus = options.focus;
  numberTests(data, results);
  noteUnlearned(data, notes);
  for (const SceneDescriptor& descriptor : data.descriptors) {
    const Features features = withParts(withRows(data.images[0].features, {}), descriptor.parts);
    const bool isLexical =
        std::all_of(features.parts.begin(), features.parts.end(),
                    [](const DescriptorPart& part) { return part.kind == PartKind::probabilities; });
    results.descriptors.push_back({descriptor.name, isLexical, descriptor.parts.size()});
  }
  results.classifiers = options.classifiers;
  if (results.classifiers.empty())
    for (const auto& [type, explanation] : classifierTypes()) results.classifiers.push_back(type);

  runGrid(options, data, grid, progress, results);
  if (options.subsets) runSubsets(options, data, run, progress, notes, results);
  writeWhole(run.folder / (options.name + "-confusions.csv"), confusionsCsv(results));
  writeWhole(run.folder / (options.name + "-images.csv"), imagesCsv(results));
  writeWhole(run.folder / (options.name + "-scores.csv"),
             scoresCsv(scoresOfCells(results, blocksOf(results))));

  Findings findings = findingsOf(results);
  if (data.figures) findings.sections.emplace_back(*data.figures);
  for (const std::string& identity : data.identities) findings.facts.emplace_back("Part", identity);
  findings.notes.insert(findings.notes.begin(), notes.begin(), notes.end());
  return findings;
}

}  // namespace estancia::experiments
