// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/training.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/objects/own_classes.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia {
namespace {

/// Some of the views of a source.
class ViewSubset : public ObjectViews {
 public:
  ViewSubset(const ObjectViews& all, std::vector<std::size_t> chosen)
      : all_(all), chosen_(std::move(chosen)) {}
  std::string name() const override { return all_.name(); }
  std::size_t size() const override { return chosen_.size(); }
  const ObjectView& view(std::size_t i) const override { return all_.view(chosen_[i]); }
  PointCloud cloud(std::size_t i) const override { return all_.cloud(chosen_[i]); }
  ObjectImage image(std::size_t i) const override { return all_.image(chosen_[i]); }

 private:
  const ObjectViews& all_;
  std::vector<std::size_t> chosen_;
};

/// Recorded labels by the names of views. If it has whole names of views, only these count: a view that the
/// labeler skipped must not get the labels of another object's "0017".
class RecordedLabels {
 public:
  RecordedLabels(const DescriptorSequence& recording, const ObjectViews& views) : labeler_(recording) {
    for (const Frame& frame : recording.frames) names_.insert(frame.name);
    for (std::size_t i = 0; i < views.size(); ++i) whole_ = whole_ || names_.contains(views.view(i).name);
  }

  std::optional<LexicalDescriptor> of(const std::string& view) {
    if (names_.empty() || (whole_ && !names_.contains(view))) return {};
    try {
      return labeler_.infer(labeler_.prepare({}, view));
    } catch (const FrameError&) {
      return {};
    }
  }

 private:
  RecordedLabeler labeler_;
  std::set<std::string> names_;
  bool whole_ = false;
};

/// The described views of all sources, with what is known of each.
struct DescribedViews {
  Features shapes;
  std::vector<int> instances = {};
  std::vector<std::string> categories = {};
  /// The labels of each source, and the vocabulary they are in.
  std::vector<std::pair<Vocabulary, DescriptorMatrix>> labels = {};
  /// A view without labels, beside one that has some: for the error.
  std::string unlabeledExample = {};
};

void requireSplit(std::span<const LabeledViews> sources, const std::string& split) {
  std::set<std::string> known;
  for (const LabeledViews& source : sources)
    for (std::size_t i = 0; i < source.views->size(); ++i) known.insert(source.views->view(i).split);
  if (split.empty() || known.contains(split)) return;
  known.erase("");
  throw Error(ErrorCode::unknownName,
              known.empty() ? fmt::format("unknown split \"{}\"; these views have no splits", split)
                            : fmt::format("unknown split \"{}\"; known: {}", split, fmt::join(known, ", ")));
}

/// The labeler of all sources; "" when none has labels.
std::string commonLabeler(std::span<const LabeledViews> sources) {
  if (sources.empty()) return "";
  const LabeledViews& first = sources.front();
  for (const LabeledViews& source : sources) {
    if (source.labels.has_value() != first.labels.has_value())
      fail(ErrorCode::mismatch,
           "{} has labels and {} has none; label both, or learn the true categories of both",
           (first.labels ? first : source).views->name(), (first.labels ? source : first).views->name());
    if (first.labels && source.labels->model != first.labels->model)
      fail(ErrorCode::mismatch, "{} was labeled by {}, but {} by {}; label both by one", source.views->name(),
           source.labels->model, first.views->name(), first.labels->model);
  }
  return first.labels ? first.labels->model : "";
}

std::string unlabeledExample(const DescriptorSequence& labels, const ObjectView& view) {
  return labels.frames.empty()
             ? "; the label file is empty"
             : fmt::format("; \"{}\" has no labels, but \"{}\" has some: are they those of other views?",
                           view.name, labels.frames.front().name);
}

/// The views to learn from; `labels` gets a row for each if there are labels; `set` counts the others.
std::vector<std::size_t> choose(const LabeledViews& source, const TrainingOptions& options, TrainingSet& set,
                                DescribedViews& described, DescriptorMatrix& labels) {
  std::optional<RecordedLabels> recorded;
  if (source.labels) recorded.emplace(*source.labels, *source.views);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < source.views->size(); ++i) {
    const ObjectView& view = source.views->view(i);
    if (!options.split.empty() && view.split != options.split) continue;
    if (!options.allViews && (view.flat || view.atBorder)) {
      ++(view.flat ? set.flat : set.atBorder);
      continue;
    }
    const auto answer = recorded ? recorded->of(view.name) : std::nullopt;
    if (recorded ? !answer : set.training.targets.classOf(view.category) < 0) {
      ++set.unlabeled;
      if (recorded && described.unlabeledExample.empty())
        described.unlabeledExample = unlabeledExample(*source.labels, view);
      continue;
    }
    if (answer) labels.append(*answer);
    chosen.push_back(i);
  }
  return chosen;
}

void append(DescriptorMatrix& rows, const DescriptorMatrix& more) {
  for (std::size_t i = 0; i < more.size(); ++i) rows.append(more.row(i));
}

DescribedViews describeViews(std::span<const LabeledViews> sources, const TrainingOptions& options,
                             TrainingSet& set, Progress& progress, std::vector<std::string>* problems) {
  DescribedViews all{.shapes = noShapes(options.shape)};
  std::map<std::tuple<std::size_t, std::string, std::string>, int> instances;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const LabeledViews& source = sources[s];
    DescriptorMatrix labels(source.labels ? source.labels->vocabulary.size() : 0);
    const ViewSubset chosen(*source.views, choose(source, options, set, all, labels));
    if (chosen.size() == 0) continue;
    const Features shapes = describeShapes(chosen, options.shape, progress, problems);
    append(all.shapes.values, shapes.values);
    all.shapes.frames.insert(all.shapes.frames.end(), shapes.frames.begin(), shapes.frames.end());
    DescriptorMatrix kept(labels.labels());
    for (std::size_t i = 0, row = 0; row < shapes.frames.size(); ++i) {  // the views that could be described
      const ObjectView& view = chosen.view(i);
      if (view.name != shapes.frames[row].name) continue;
      ++row;
      const auto next = static_cast<int>(instances.size());
      all.instances.push_back(instances.try_emplace({s, view.category, view.instance}, next).first->second);
      all.categories.push_back(view.category);
      if (source.labels) kept.append(labels.row(i));
    }
    if (source.labels) all.labels.emplace_back(source.labels->vocabulary, std::move(kept));
  }
  return all;
}

/// The classes that the labels make themselves.
OwnClasses ownClassesOf(const DescribedViews& views, const TrainingOptions& options, Progress& progress) {
  if (views.labels.empty())
    fail(ErrorCode::invalidOption, "there are neither target classes nor labels that could make some");
  const Vocabulary& vocabulary = views.labels.front().first;
  DescriptorMatrix labels(vocabulary.size());
  for (const auto& [known, some] : views.labels) {
    if (known != vocabulary)
      fail(ErrorCode::mismatch,
           "the label files have different vocabularies; label the views anew, or give classes");
    append(labels, some);
  }
  OwnClasses own = findOwnClasses(vocabulary, *installedConcepts(vocabulary, {}), labels, views.instances,
                                  views.shapes, options.classifier, options.minCoverage, progress);
  if (own.classes.size() < 2)
    fail(ErrorCode::insufficientData,
         "the labels make {} of {} objects, and a model needs two: {}; collect more views and objects, or "
         "give "
         "target classes (--study)",
         own.classes.empty() ? "no class" : fmt::format("one class ({})", own.classes.front().name),
         std::set<int>(views.instances.begin(), views.instances.end()).size(), leftOutOf(own));
  return own;
}

/// p(class | image) of the target classes.
ClassProbabilities restrictLabels(const DescribedViews& views, const TargetClasses& targets) {
  ClassProbabilities all{DescriptorMatrix(targets.classes.size()), {}};
  for (const auto& [vocabulary, labels] : views.labels) {
    const ClassProbabilities some = restrictTo(targets, vocabulary, labels);
    append(all.probabilities, some.probabilities);
    all.coverage.insert(all.coverage.end(), some.coverage.begin(), some.coverage.end());
  }
  return all;
}

/// Clears the probabilities of instances of no target class: mean coverage below the minimum, or none of
/// `ownClasses`, unless these are empty.
ClassProbabilities rejectOthers(const ClassProbabilities& answers, const std::vector<int>& instances,
                                double minCoverage, const std::vector<int>& ownClasses) {
  std::map<int, std::pair<double, double>> sums;  // coverage and number of the samples of an instance
  for (std::size_t i = 0; i < instances.size(); ++i) {
    sums[instances[i]].first += answers.coverage[i];
    ++sums[instances[i]].second;
  }
  ClassProbabilities accepted{DescriptorMatrix(answers.probabilities.labels()), answers.coverage};
  const std::vector<float> none(answers.probabilities.labels(), 0);
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const auto& [coverage, samples] = sums[instances[i]];
    const bool other = coverage < minCoverage * samples || (!ownClasses.empty() && ownClasses[i] < 0);
    accepted.probabilities.append(other ? DescriptorView(none) : answers.probabilities.row(i));
  }
  return accepted;
}

void countClasses(const std::vector<int>& trueClasses, TrainingSet& set) {
  const ObjectTraining& training = set.training;
  set.samples.assign(training.targets.classes.size(), 0);
  std::vector<std::set<int>> instances(set.samples.size());
  for (std::size_t i = 0; i < training.classes.size(); ++i) {
    if (training.classes[i] < 0) {
      ++set.rejected;
      continue;
    }
    const auto c = static_cast<std::size_t>(training.classes[i]);
    ++set.samples[c];
    instances[c].insert(training.instances[i]);
    set.comparable += trueClasses[i] >= 0 ? 1 : 0;
    set.correct += trueClasses[i] == training.classes[i] ? 1 : 0;
  }
  for (const auto& ofClass : instances) set.instances.push_back(ofClass.size());
}

/// The two most frequent labels of all views: "\"wall\" and \"bottle\"".
std::string frequentLabels(const DescribedViews& views) {
  std::map<std::string, double> sums;
  for (const auto& [vocabulary, labels] : views.labels) {
    const std::vector<float> often = priorOf({labels, {}});
    for (std::size_t label = 0; label < often.size(); ++label)
      sums[shortLabel(vocabulary[label])] += often[label] * static_cast<double>(labels.size());
  }
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [label, sum] : sums) order.emplace_back(-sum, label);
  std::ranges::sort(order);
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(order.size(), 2); ++i)
    text += fmt::format("{}\"{}\"", i == 0 ? "" : " and ", order[i].second);
  return text;
}

void requireViews(const DescribedViews& views, const TrainingSet& set) {
  if (!views.instances.empty()) return;
  fail(ErrorCode::insufficientData,
       "no views to learn from: {} are flat, {} cut by the border, {} without labels or a target class{}",
       set.flat, set.atBorder, set.unlabeled, views.unlabeledExample);
}

void requireClasses(const DescribedViews& views, const TrainingSet& set, const TrainingOptions& options) {
  if (set.rejected < set.training.classes.size()) return;
  const bool limited = options.minCoverage > 0;
  fail(ErrorCode::insufficientData,
       "none of {} views gets a target class: the classes cover {:.1f} % of the labeler's answers{}, which "
       "are mostly {}; give the classes labels that it uses{}",
       set.training.classes.size(), 100 * set.coverage,
       limited ? fmt::format(" (the minimum is {})", options.minCoverage) : "", frequentLabels(views),
       limited ? ", or a smaller minimum" : "");
}

}  // namespace

OptionGroup declare(TrainingOptions& options) {
  OptionGroup group("training", "Self-supervised training of an object model.");
  const Choices labelings = pseudoLabelings();
  group.add("pseudo-labels", options.pseudoLabels,
            {{labelings[0], PseudoLabeling::top},
             {labelings[1], PseudoLabeling::voted},
             {labelings[2], PseudoLabeling::confident}},
            "How class probabilities become pseudo-labels.");
  group
      .add("correct-prior", &options.correctPrior,
           "Divide the labeler's probabilities by how often it gives each class.")
      .why("off if the classes really are as frequent as the labeler says");
  group
      .add("min-coverage", &options.minCoverage,
           "Objects whose labels cover the target classes less than this on average are of no target class.")
      .range(0, 1)
      .why("raise it if other objects are learned as targets");
  group.add("all-views", &options.allViews,
            "Also use flat views and those cut by the image border, which do not show the whole shape.");
  group.add("split", &options.split, "Use only the views of this part of the data set.")
      .automatic("all views");
  group.add(declare(options.shape));
  OptionGroup classifier = declare(options.classifier);
  constexpr std::string_view details[] = {"c", "folds", "gamma", "metric", "neighbors", "trees"};
  std::erase_if(classifier.options(), [&](const Option& o) { return std::ranges::count(details, o.name()); });
  group.add(std::move(classifier));
  return group;
}

TrainingSet gatherTraining(std::span<const LabeledViews> sources, const TargetClasses& targets,
                           const TrainingOptions& options, Progress& progress,
                           std::vector<std::string>* problems) {
  validate(options);
  validate(options.classifier);  // before the long work
  requireSplit(sources, options.split);
  TrainingSet set{
      {targets, options.shape, {{}, {}, DescriptorMatrix(0)}, {}, {}, commonLabeler(sources), {}}};
  set.coverage = 1;
  ObjectTraining& training = set.training;
  const DescribedViews views = describeViews(sources, options, set, progress, problems);
  requireViews(views, set);
  training.shapes = views.shapes;
  training.instances = views.instances;
  if (targets.classes.empty()) {
    set.own = std::make_shared<OwnClasses>(ownClassesOf(views, options, progress));
    training.targets = targetClassesOf(*set.own, views.labels.front().first);
  }
  std::vector<int> trueClasses;
  for (const std::string& category : views.categories)
    trueClasses.push_back(training.targets.classOf(category));
  training.classes = trueClasses;
  if (!views.labels.empty()) {
    ClassProbabilities p =
        restrictLabels(views, training.targets);  // 1. p(class | image) ∝ Σ p(label | image), thesis 6.3
    set.coverage =
        std::accumulate(p.coverage.begin(), p.coverage.end(), 0.0) / static_cast<double>(p.coverage.size());
    p = rejectOthers(p, views.instances, options.minCoverage,
                     set.own ? set.own->classOf : std::vector<int>());
    if (options.correctPrior && !set.own) {  // 2. p(class | image) / p(class), Saerens et al. 2002
      training.prior = priorOf(p);
      p = corrected(p, training.prior);
    }
    training.classes = assignPseudoLabels(options.pseudoLabels, p, views.instances, views.shapes,  // 3. vote
                                          options.classifier, progress);
  }
  countClasses(trueClasses, set);
  requireClasses(views, set, options);
  return set;  // 4. trainObjectModel() learns the shapes of the classes
}

std::vector<std::string> categoriesOf(std::span<const LabeledViews> sources) {
  std::set<std::string> categories;
  for (const LabeledViews& source : sources)
    for (std::size_t i = 0; i < source.views->size(); ++i) categories.insert(source.views->view(i).category);
  categories.erase("");
  return {categories.begin(), categories.end()};
}

}  // namespace estancia
