// SPDX-License-Identifier: Apache-2.0
#include "objects/object_splits_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/words/installed_words.hpp"
#include "objects/instance_splits.hpp"

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

  /// Views of the study's classes.
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

  /// The labeler's answers for the views, by the view's name.
  const DescriptorSequence& recordedLabels(const ObjectSplitsOptions::Data& data, const ObjectViews& views,
                                           Labeler& labeler) {
    auto& labels = labels_[viewsKey(data) + "\n" + labeler.identity() + data.labels.string()];
    if (labels) return *labels;
    const auto patches = cropsOf(views);
    std::vector<std::string> problems;
    try {
      labels = labelAll(*patches, labeler, "labeling " + data.name, {.cache = run_.cache}, progress_,
                        [&](const LabeledFrame& frame) {
                          if (!frame.labeled()) problems.push_back(frame.problem);
                        });
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      throw Error(problem.code(), fmt::format("{}: {}", data.name, problem.what()));
    }
    tell(data, problems, "has no labels");
    return *labels;
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
  std::map<std::string, std::optional<DescriptorSequence>> labels_;
};

TargetClasses studyOf(const ObjectSplitsOptions::Data& data) {
  if (!data.study.empty()) return readTargetClasses(data.study);
  const auto views = openObjectViews(data.views, data.reading);
  std::set<std::string> named;
  for (std::size_t i = 0; i < views->size(); ++i)
    if (!views->view(i).category.empty()) named.insert(views->view(i).category);
  if (named.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: the category of no view is known", data.views.string()));
  return targetClassesOf({named.begin(), named.end()});
}

void require(const ObjectTask& task) {
  std::set<int> shown(task.classes.begin(), task.classes.end());
  if (shown.size() < 2)
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: all views show one class, {}; there must be two to tell apart",
                            task.data->views.string(),
                            task.targets.classes[static_cast<std::size_t>(*shown.begin())].name));
  if (!task.labels) return;
  const auto& mass = task.labels->restricted.coverage;
  if (std::none_of(mass.begin(), mass.end(), [](float m) { return m > 0; }))
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: the labeler gives none of the study's classes of any view; is it one that "
                            "knows them?",
                            task.data->name));
}

std::string digestOf(const ObjectTask& task) {
  const auto bytes = [](const std::vector<float>& values) {
    return sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
  };
  std::string told = bytes(task.shapes.values.values());
  for (const DescriptorPart& part : task.shapes.parts) told += part.identity + "\n";
  for (std::size_t i = 0; i < task.classes.size(); ++i)
    told += fmt::format("{} {} {} {}\n", task.shapes.frames[i].name, task.classes[i], task.objects[i],
                        task.groups[i]);
  told += fmt::format("{}\n", fmt::join(task.targets.names(), "\n"));
  if (task.labels) told += task.labels->labeler + bytes(task.labels->restricted.probabilities.values());
  return sha256(told);
}

/// Contiguous thirds of each object's samples, in order.
std::vector<int> thirdsOf(const std::vector<int>& objects) {
  std::map<int, int> counts, seen;
  for (const int object : objects) ++counts[object];
  std::vector<int> third;
  third.reserve(objects.size());
  for (const int object : objects) third.push_back(seen[object]++ * thirds / counts[object]);
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

ObjectSplit splitByObjects(const ObjectTask& task, const InstanceSplit& split) {
  return splitBy(split.name, task.objects, {split.test.begin(), split.test.end()},
                 {split.train.begin(), split.train.end()});
}

std::vector<ObjectSplit> splitsByInstances(const ObjectTask& task, const std::vector<double>& labeled,
                                           const ObjectSplitsOptions& options) {
  std::vector<ObjectSplit> splits;
  if (!labeled.empty()) splits.push_back(splitByObjects(task, baselineSplit(task.classOfObject, labeled)));
  for (const InstanceSplit& split : randomSplits(task.classOfObject, options.splits, options.splitSeed))
    splits.push_back(splitByObjects(task, split));
  return splits;
}

std::vector<ObjectSplit> splitsByViews(const ObjectTask& task) {
  std::map<int, std::size_t> counts;
  for (const int object : task.objects) ++counts[object];
  for (const auto& [object, count] : counts)
    if (count < thirds)
      throw Error(
          ErrorCode::insufficientData,
          fmt::format("{}: {} has {} views, too few for thirds; split it by instances",
                      task.data->views.string(), task.objectNames[static_cast<std::size_t>(object)], count));
  const std::vector<int> third = thirdsOf(task.objects);
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
    parts[task.objects[i]].insert(part);
  }
  for (const auto& [object, of] : parts)
    if (of.contains("train") && of.contains("test"))
      throw Error(ErrorCode::mismatch,
                  fmt::format("{}: {} is both in the training and in the test part; split by instances",
                              task.data->views.string(), task.objectNames[static_cast<std::size_t>(object)]));
  return {std::move(split)};
}

/// Share of right answers among each object's samples; a missing answer is wrong.
std::vector<double> labeledOf(const ObjectTask& task, const ClassProbabilities& shares) {
  std::vector<double> right(task.objectNames.size()), all(task.objectNames.size());
  for (std::size_t i = 0; i < task.objects.size(); ++i) {
    const auto object = static_cast<std::size_t>(task.objects[i]);
    const auto row = shares.probabilities.row(i);
    const auto best = std::max_element(row.begin(), row.end());
    ++all[object];
    right[object] += *best > 0 && best - row.begin() == task.classes[i];
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
    for (const std::size_t i : split.train) learned.insert(task.classes[i]);
    if (learned.size() < 2)
      throw Error(
          ErrorCode::insufficientData,
          fmt::format("{}: all views to learn from in the split {} show one class, {}", here, split.name,
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
  const DescriptorSequence* labels =
      labeler == nullptr ? nullptr : &shared.recordedLabels(data, *task.views, *labeler);
  if (labels != nullptr)
    task.targets = withLabelKinds(task.targets, labels->vocabulary, installedWordGraph, &notes);

  std::map<std::string, std::size_t> viewNamed, labelsOf;
  for (std::size_t i = 0; i < task.views->size(); ++i) viewNamed.emplace(task.views->view(i).name, i);
  if (labels != nullptr)
    for (std::size_t i = 0; i < labels->frames.size(); ++i) labelsOf.emplace(labels->frames[i].name, i);
  std::vector<std::size_t> rows;
  if (labels != nullptr)
    task.labels = {labels->model,
                   labels->vocabulary,
                   DescriptorMatrix(labels->vocabulary.size()),
                   {DescriptorMatrix(task.targets.classes.size()), {}}};
  std::map<std::string, int> objects;
  for (std::size_t row = 0; row < all.frames.size(); ++row) {
    const std::string& name = all.frames[row].name;
    const auto labelRow = labelsOf.find(name);
    if (labels != nullptr && labelRow == labelsOf.end()) continue;
    if (labels != nullptr) task.labels->descriptors.append(labels->descriptors.row(labelRow->second));
    rows.push_back(row);
    task.view.push_back(viewNamed.at(name));
    const ObjectView& view = task.views->view(task.view.back());
    task.classes.push_back(task.targets.classOf(view.category));
    const auto [object, isNew] = objects.emplace(view.instance, static_cast<int>(objects.size()));
    if (isNew) {
      task.objectNames.push_back(view.instance);
      task.classOfObject.push_back(task.classes.back());
    }
    task.objects.push_back(object->second);
  }
  if (rows.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: no view has both labels and a shape", data.views.string()));
  if (rows.size() < all.frames.size())
    notes.push_back(fmt::format("{}: {} of {} views have no labels and were left out", data.name,
                                all.frames.size() - rows.size(), all.frames.size()));
  task.shapes = withRows(all, rows);
  task.groups = task.objects;
  if (data.split == Split::views) {
    const std::vector<int> third = thirdsOf(task.objects);
    for (std::size_t i = 0; i < third.size(); ++i) task.groups[i] = task.objects[i] * thirds + third[i];
  }
  if (task.labels)
    task.labels->restricted = restrictTo(task.targets, task.labels->vocabulary, task.labels->descriptors);
  require(task);
  task.splits =
      splitsOf(task, task.labels ? labeledOf(task, task.labels->restricted) : std::vector<double>{}, options);
  task.digest = digestOf(task);
  return task;
}

}  // namespace

std::vector<ObjectTask> prepareTasks(const ObjectSplitsOptions& options, const ExperimentRun& run,
                                     Progress& progress, std::vector<std::string>& notes) {
  if (run.models.size() > 1)
    throw Error(ErrorCode::invalidOption,
                fmt::format("one model names the objects at a time; run {} one by one",
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
