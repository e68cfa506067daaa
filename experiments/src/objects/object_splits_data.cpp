// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/objects/object_splits_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/label/model.hpp"
#include "estancia/label/record.hpp"
#include "estancia/label/recorded_labeler.hpp"
#include "estancia/objects/object_crops.hpp"
#include "experiments/src/objects/instance_splits.hpp"

namespace estancia::experiments {
namespace {

namespace fs = std::filesystem;
using Split = ObjectSplitsOptions::Split;

constexpr int thirds = 3;

/// Some of the views.
class SomeViews final : public ObjectViews {
 public:
  SomeViews(std::unique_ptr<ObjectViews> all, std::vector<std::size_t> chosen)
      : all_(std::move(all)), chosen_(std::move(chosen)) {
    warnings_ = all_->warnings();
  }
  std::string name() const override { return all_->name(); }
  std::size_t size() const override { return chosen_.size(); }
  const ObjectView& view(std::size_t i) const override { return all_->view(chosen_.at(i)); }
  PointCloud cloud(std::size_t i) const override { return all_->cloud(chosen_.at(i)); }
  ObjectImage image(std::size_t i) const override { return all_->image(chosen_.at(i)); }

 private:
  std::unique_ptr<ObjectViews> all_;
  std::vector<std::size_t> chosen_;
};

/// What several data may have in common.
class Shared {
 public:
  Shared(const ExperimentRun& run, Progress& progress, std::vector<std::string>& notes)
      : run_(run), progress_(progress), notes_(notes) {}

  /// The labeler of the data, opened before anything is read; null: none.
  Labeler* labelerOf(const ObjectSplitsOptions::Data& data) {
    const std::string model = modelOf(data);
    if (model.empty() && data.labels.empty()) return nullptr;
    auto& labeler = labelers_[model.empty() ? data.labels.string() : model];
    if (labeler == nullptr && model.empty()) {
      labeler = std::make_unique<RecordedLabeler>(readDescriptors(data.labels));
    } else if (labeler == nullptr) {
      LabelerOptions options = run_.labeler;
      options.onDemand = true;
      labeler = loadModel(model, options);
    }
    return labeler.get();
  }

  /// Those of the study's words.
  std::shared_ptr<const ObjectViews> viewsOf(const ObjectSplitsOptions::Data& data,
                                             const TargetClasses& study) {
    auto& views = views_[viewsKey(data)];
    if (views != nullptr) return views;
    auto all = openObjectViews(data.views, data.reading);
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < all->size(); ++i)
      if (study.classOf(all->view(i).category) >= 0) chosen.push_back(i);
    if (chosen.empty())
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: no view is of a category of the study {}; name categories in it",
                              data.views.string(), data.study.string()));
    views = std::make_shared<SomeViews>(std::move(all), std::move(chosen));
    for (const std::string& warning : views->warnings())
      notes_.push_back(fmt::format("{}: {}", data.name, warning));
    return views;
  }

  const Features& describeShapes(const ObjectSplitsOptions::Data& data, const ObjectViews& views) {
    auto& shapes = shapes_[fmt::format("{}\n{} {} {}", viewsKey(data), data.shape.samples, data.shape.size,
                                       data.shape.seed)];
    if (shapes) return *shapes;
    ShapeOptions options = data.shape;
    options.threads = run_.labeler.threads;
    std::vector<std::string> problems;
    shapes = estancia::describeShapes(views, options, progress_, &problems);
    tell(data, problems, "has no shape");
    return *shapes;
  }

  /// What the labeler says of the views, by the view's name.
  const DescriptorSequence& wordsOf(const ObjectSplitsOptions::Data& data, const ObjectViews& views,
                                    Labeler& labeler) {
    auto& words = words_[viewsKey(data) + "\n" + labeler.identity() + data.labels.string()];
    if (words) return *words;
    const auto patches = cropsOf(views);
    std::vector<std::string> problems;
    try {
      words = labelAll(*patches, labeler, "labeling " + data.name, {.cache = run_.cache}, progress_,
                       [&](const LabeledFrame& frame) {
                         if (!frame.labeled()) problems.push_back(frame.problem);
                       });
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      throw Error(problem.code(), fmt::format("{}: {}", data.name, problem.what()));
    }
    tell(data, problems, "has no words");
    return *words;
  }

 private:
  static std::string viewsKey(const ObjectSplitsOptions::Data& data) {
    return fmt::format("{}\n{} {}\n{}", data.views.string(), data.reading.type, data.reading.minPoints,
                       data.study.string());
  }

  std::string modelOf(const ObjectSplitsOptions::Data& data) const {
    const bool asks = !data.model.empty() || !data.labels.empty();
    return asks && !run_.models.empty() ? run_.models.front() : data.model;
  }

  void tell(const ObjectSplitsOptions::Data& data, const std::vector<std::string>& problems,
            const char* what) {
    if (!problems.empty())
      notes_.push_back(fmt::format("{}: {} of the views {} and was left out; the first: {}", data.name,
                                   problems.size(), what, problems.front()));
  }

  const ExperimentRun& run_;
  Progress& progress_;
  std::vector<std::string>& notes_;
  std::map<std::string, std::unique_ptr<Labeler>> labelers_;
  std::map<std::string, std::shared_ptr<const ObjectViews>> views_;
  std::map<std::string, std::optional<Features>> shapes_;
  std::map<std::string, std::optional<DescriptorSequence>> words_;
};

TargetClasses studyOf(const ObjectSplitsOptions::Data& data) {
  if (!data.study.empty()) return readTargetClasses(data.study);
  const auto views = openObjectViews(data.views, data.reading);
  std::set<std::string> categories;
  for (std::size_t i = 0; i < views->size(); ++i)
    if (!views->view(i).category.empty()) categories.insert(views->view(i).category);
  if (categories.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: the category of no view is known", data.views.string()));
  return targetClassesOf({categories.begin(), categories.end()});
}

void require(const ObjectTask& task) {
  std::set<int> shown(task.words.begin(), task.words.end());
  if (shown.size() < 2)
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: all views show one word, {}; there must be two to tell apart",
                            task.data->views.string(),
                            task.targets.classes[static_cast<std::size_t>(*shown.begin())].name));
  if (!task.said) return;
  const auto& mass = task.said->restricted.coverage;
  if (std::none_of(mass.begin(), mass.end(), [](float m) { return m > 0; }))
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: the labeler says none of the study's words of any view; is it one that "
                            "knows them?",
                            task.data->name));
}

std::string digestOf(const ObjectTask& task) {
  const auto bytes = [](const std::vector<float>& values) {
    return sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
  };
  std::string told = bytes(task.shapes.values.values());
  for (const DescriptorPart& part : task.shapes.parts) told += part.identity + "\n";
  for (std::size_t i = 0; i < task.words.size(); ++i)
    told += fmt::format("{} {} {} {}\n", task.shapes.frames[i].name, task.words[i], task.things[i],
                        task.groups[i]);
  told += fmt::format("{}\n", fmt::join(task.targets.names(), "\n"));
  if (task.said) told += task.said->labeler + bytes(task.said->restricted.probabilities.values());
  return sha256(told);
}

/// Contiguous thirds of each thing's samples, in order.
std::vector<int> thirdsOf(const std::vector<int>& things) {
  std::map<int, int> counts, seen;
  for (const int thing : things) ++counts[thing];
  std::vector<int> third;
  third.reserve(things.size());
  for (const int thing : things) third.push_back(seen[thing]++ * thirds / counts[thing]);
  return third;
}

ObjectSplit splitBy(const std::string& name, const std::vector<int>& of, const std::vector<int>& tested,
                    const std::vector<int>& learned) {
  ObjectSplit split{name, {}, {}};
  for (std::size_t i = 0; i < of.size(); ++i) {
    if (std::find(tested.begin(), tested.end(), of[i]) != tested.end()) split.test.push_back(i);
    if (std::find(learned.begin(), learned.end(), of[i]) != learned.end()) split.train.push_back(i);
  }
  return split;
}

ObjectSplit splitByThings(const ObjectTask& task, const InstanceSplit& split) {
  return splitBy(split.name, task.things, {split.test.begin(), split.test.end()},
                 {split.train.begin(), split.train.end()});
}

std::vector<ObjectSplit> splitsByInstances(const ObjectTask& task, const std::vector<double>& labeled,
                                           const ObjectSplitsOptions& options) {
  std::vector<ObjectSplit> splits;
  if (!labeled.empty()) splits.push_back(splitByThings(task, baselineSplit(task.wordOfThing, labeled)));
  for (const InstanceSplit& split : randomSplits(task.wordOfThing, options.splits, options.splitSeed))
    splits.push_back(splitByThings(task, split));
  return splits;
}

std::vector<ObjectSplit> splitsByViews(const ObjectTask& task) {
  std::map<int, std::size_t> counts;
  for (const int thing : task.things) ++counts[thing];
  for (const auto& [thing, count] : counts)
    if (count < thirds)
      throw Error(
          ErrorCode::insufficientData,
          fmt::format("{}: {} has {} views, too few for thirds; split it by instances",
                      task.data->views.string(), task.thingNames[static_cast<std::size_t>(thing)], count));
  const std::vector<int> third = thirdsOf(task.things);
  return {splitBy("views 1", third, {0}, {1, 2}), splitBy("views 2", third, {1}, {0, 2}),
          splitBy("views 3", third, {2}, {0, 1})};
}

std::vector<ObjectSplit> officialSplits(const ObjectTask& task) {
  ObjectSplit split{"official", {}, {}};
  std::map<int, std::set<std::string>> parts;
  for (std::size_t i = 0; i < task.view.size(); ++i) {
    const std::string& part = task.views->view(task.view[i]).split;
    if (part == "train") split.train.push_back(i);
    if (part == "test") split.test.push_back(i);
    parts[task.things[i]].insert(part);
  }
  for (const auto& [thing, of] : parts)
    if (of.contains("train") && of.contains("test"))
      throw Error(ErrorCode::mismatch,
                  fmt::format("{}: {} is both in the training and in the test part; split by instances",
                              task.data->views.string(), task.thingNames[static_cast<std::size_t>(thing)]));
  return {std::move(split)};
}

/// The right answers' share of each thing's samples; what says nothing is wrong.
std::vector<double> labeledOf(const ObjectTask& task, const ClassProbabilities& shares) {
  std::vector<double> right(task.thingNames.size()), all(task.thingNames.size());
  for (std::size_t i = 0; i < task.things.size(); ++i) {
    const auto thing = static_cast<std::size_t>(task.things[i]);
    const auto row = shares.probabilities.row(i);
    const auto best = std::max_element(row.begin(), row.end());
    ++all[thing];
    right[thing] += *best > 0 && best - row.begin() == task.words[i];
  }
  for (std::size_t t = 0; t < right.size(); ++t) right[t] /= all[t];
  return right;
}

/// `labeled` (labeledOf()) is empty where no labeler was asked: then there is no baseline.
std::vector<ObjectSplit> splitsOf(const ObjectTask& task, const std::vector<double>& labeled,
                                  const ObjectSplitsOptions& options) {
  const std::string here = task.data->views.string();
  std::vector<ObjectSplit> splits;
  try {
    splits = task.data->split == Split::instances ? splitsByInstances(task, labeled, options)
             : task.data->split == Split::views   ? splitsByViews(task)
                                                  : officialSplits(task);
  } catch (const Error& problem) {
    const std::string what = problem.what();
    throw Error(problem.code(), what.starts_with(here) ? what : here + ": " + what);
  }
  for (const ObjectSplit& split : splits) {
    if (split.train.empty() || split.test.empty())
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: the split {} has {} views to learn from and {} to ask about", here,
                              split.name, split.train.size(), split.test.size()));
    std::set<int> learned;
    for (const std::size_t i : split.train) learned.insert(task.words[i]);
    if (learned.size() < 2)
      throw Error(
          ErrorCode::insufficientData,
          fmt::format("{}: all views to learn from in the split {} show one word, {}", here, split.name,
                      task.targets.classes[static_cast<std::size_t>(*learned.begin())].name));
  }
  return splits;
}

ObjectTask prepare(const ObjectSplitsOptions::Data& data, Shared& shared, const ObjectSplitsOptions& options,
                   std::vector<std::string>& notes) {
  Labeler* labeler = shared.labelerOf(data);
  ObjectTask task{
      &data, studyOf(data), nullptr, {}, {{}, {}, DescriptorMatrix(0)}, {}, {}, {}, {}, {}, {}, {}, {}};
  task.views = shared.viewsOf(data, task.targets);
  const Features& all = shared.describeShapes(data, *task.views);
  const DescriptorSequence* words =
      labeler == nullptr ? nullptr : &shared.wordsOf(data, *task.views, *labeler);

  std::map<std::string, std::size_t> viewNamed, wordsOf;
  for (std::size_t i = 0; i < task.views->size(); ++i) viewNamed.emplace(task.views->view(i).name, i);
  if (words != nullptr)
    for (std::size_t i = 0; i < words->frames.size(); ++i) wordsOf.emplace(words->frames[i].name, i);
  std::vector<std::size_t> rows;
  if (words != nullptr)
    task.said = {words->model,
                 words->vocabulary,
                 DescriptorMatrix(words->vocabulary.size()),
                 {DescriptorMatrix(task.targets.classes.size()), {}}};
  std::map<std::string, int> things;
  for (std::size_t row = 0; row < all.frames.size(); ++row) {
    const std::string& name = all.frames[row].name;
    const auto said = wordsOf.find(name);
    if (words != nullptr && said == wordsOf.end()) continue;
    if (words != nullptr) task.said->descriptors.append(words->descriptors.row(said->second));
    rows.push_back(row);
    task.view.push_back(viewNamed.at(name));
    const ObjectView& view = task.views->view(task.view.back());
    task.words.push_back(task.targets.classOf(view.category));
    const auto [thing, isNew] = things.emplace(view.instance, static_cast<int>(things.size()));
    if (isNew) {
      task.thingNames.push_back(view.instance);
      task.wordOfThing.push_back(task.words.back());
    }
    task.things.push_back(thing->second);
  }
  if (rows.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no view has both words and a shape", data.views.string()));
  if (rows.size() < all.frames.size())
    notes.push_back(fmt::format("{}: {} of {} views have no words and were left out", data.name,
                                all.frames.size() - rows.size(), all.frames.size()));
  task.shapes = withRows(all, rows);
  task.groups = task.things;
  if (data.split == Split::views) {
    const std::vector<int> third = thirdsOf(task.things);
    for (std::size_t i = 0; i < third.size(); ++i) task.groups[i] = task.things[i] * thirds + third[i];
  }
  if (task.said)
    task.said->restricted = restrictTo(task.targets, task.said->vocabulary, task.said->descriptors);
  require(task);
  task.splits =
      splitsOf(task, task.said ? labeledOf(task, task.said->restricted) : std::vector<double>{}, options);
  task.digest = digestOf(task);
  return task;
}

}  // namespace

std::vector<ObjectTask> prepareTasks(const ObjectSplitsOptions& options, const ExperimentRun& run,
                                     Progress& progress, std::vector<std::string>& notes) {
  if (run.models.size() > 1)
    throw Error(ErrorCode::invalidOption,
                fmt::format("one model names the things at a time; run {} one by one",
                            fmt::join(run.models, " and ")));
  Shared shared(run, progress, notes);
  for (const ObjectSplitsOptions::Data& data : options.data) shared.labelerOf(data);
  std::vector<ObjectTask> tasks;
  for (const ObjectSplitsOptions::Data& data : options.data) {
    if (data.optional && !fs::exists(data.views)) {
      notes.push_back(fmt::format("{} is not there and was left out", data.views.string()));
      continue;
    }
    tasks.push_back(prepare(data, shared, options, notes));
  }
  if (tasks.empty())
    throw Error(ErrorCode::insufficientData, "none of the data is there; name yours by [[data]]");
  return tasks;
}

}  // namespace estancia::experiments
