#include "estancia/objects/training.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/label/recorded_labeler.hpp"

namespace estancia {
namespace {

/// Some of other views.
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

/// What a labeler said, found by the names of views, whatever the recording calls their images. Where it
/// has whole names of views these alone count: a view that was skipped has not the words of another thing's
/// "0017".
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

void requireSplit(std::span<const LabeledViews> sources, const std::string& split) {
  std::set<std::string> known;
  for (const LabeledViews& source : sources)
    for (std::size_t i = 0; i < source.views->size(); ++i) known.insert(source.views->view(i).split);
  if (split.empty() || known.contains(split)) return;
  known.erase("");
  throw Error(
      known.empty()
          ? fmt::format("no view belongs to a split \"{}\": these views have no splits", split)
          : fmt::format("no view belongs to a split \"{}\"; there are {}", split, fmt::join(known, ", ")));
}

void append(DescriptorMatrix& rows, const DescriptorMatrix& more) {
  for (std::size_t i = 0; i < more.size(); ++i) rows.append(more.row(i));
}

Features noShapes(const ShapeOptions& options) {
  Features none{shapeParts(options), {}, DescriptorMatrix(0)};
  std::size_t columns = 0;
  for (const DescriptorPart& part : none.parts) columns += part.size();
  none.values = DescriptorMatrix(columns);
  return none;
}

class TrainingSetBuilder {
 public:
  TrainingSetBuilder(const TargetClasses& study, const TrainingOptions& options, bool labeled)
      : study_(study), options_(options), labeled_(labeled) {}

  void add(const LabeledViews& source, std::size_t number, Progress& progress,
           std::vector<std::string>* problems) {
    DescriptorMatrix answers(labeled_ ? source.words->vocabulary.size() : 0);
    const ViewSubset chosen(*source.views, choose(source, answers));
    if (chosen.size() == 0) return;
    const Features shapes = sampleSegments(chosen, options_.shape, progress, problems);
    Features& all = gathered_.training.shapes;
    append(all.values, shapes.values);
    all.frames.insert(all.frames.end(), shapes.frames.begin(), shapes.frames.end());
    DescriptorMatrix said(answers.labels());
    for (std::size_t i = 0, row = 0; row < shapes.frames.size(); ++i) {  // those that could be described
      const ObjectView& view = chosen.view(i);
      if (view.name != shapes.frames[row].name) continue;
      ++row;
      gathered_.training.instances.push_back(instanceOf(number, view));
      truths_.push_back(study_.wordOf(view.category));
      if (labeled_) said.append(answers.row(i));
    }
    if (!labeled_) return;
    const Vocabulary& vocabulary = source.words->vocabulary;
    const ClassProbabilities shares = restrictTo(study_, vocabulary, said);
    append(shares_.shares, shares.shares);
    shares_.mass.insert(shares_.mass.end(), shares.mass.begin(), shares.mass.end());
    const std::vector<float> often = priorOf({said, {}});
    for (std::size_t label = 0; label < often.size(); ++label)
      often_[shortLabel(vocabulary[label])] += often[label] * static_cast<double>(said.size());
  }

  TrainingSet finish(const std::string& labeler, Progress& progress) {
    ObjectTraining& training = gathered_.training;
    if (training.instances.empty())
      throw Error(
          fmt::format("there is nothing to learn from: {} flat views and {} cut by the border were "
                      "left out, {} have no words or a category that is no word of the study{}",
                      gathered_.flat, gathered_.atBorder, gathered_.without, stranger_));
    training.words = labeled_ ? namesBy(labeler, progress) : truths_;
    gathered_.mass = 1;
    if (labeled_) {
      double sum = 0;
      for (const float mass : shares_.mass) sum += mass;
      gathered_.mass = sum / static_cast<double>(shares_.mass.size());
    }
    count();
    requireNames();
    return std::move(gathered_);
  }

 private:
  /// Fills `answers` with what was said of those that are chosen, one row each.
  std::vector<std::size_t> choose(const LabeledViews& source, DescriptorMatrix& answers) {
    std::optional<RecordedLabels> words;
    if (labeled_) words.emplace(*source.words, *source.views);
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < source.views->size(); ++i) {
      const ObjectView& view = source.views->view(i);
      if (!options_.split.empty() && view.split != options_.split) continue;
      if (!options_.all && (view.flat || view.atBorder)) {
        ++(view.flat ? gathered_.flat : gathered_.atBorder);
        continue;
      }
      const auto answer = labeled_ ? words->of(view.name) : std::nullopt;
      if (labeled_ ? !answer : study_.wordOf(view.category) < 0) {
        ++gathered_.without;
        if (labeled_ && stranger_.empty()) stranger_ = strange(*source.words, view);
        continue;
      }
      if (answer) answers.append(*answer);
      chosen.push_back(i);
    }
    return chosen;
  }

  static std::string strange(const DescriptorSequence& words, const ObjectView& view) {
    return words.frames.empty()
               ? "; the file of words is empty"
               : fmt::format(
                     "; there are no words for \"{}\", but some for \"{}\": are they those of other views?",
                     view.name, words.frames.front().name);
  }

  int instanceOf(std::size_t source, const ObjectView& view) {
    const auto next = static_cast<int>(instances_.size());
    return instances_.try_emplace({source, view.category, view.instance}, next).first->second;
  }

  std::vector<int> namesBy(const std::string& labeler, Progress& progress) {
    ObjectTraining& training = gathered_.training;
    training.labeler = labeler;
    ClassProbabilities shares = withoutStrangers();
    if (options_.correct) {
      training.prior = priorOf(shares);
      shares = corrected(shares, training.prior);
    }
    return assignPseudoLabels(options_.naming, shares, training.instances, training.shapes,
                              options_.classifier, progress);
  }

  /// Nothing is said of things that the labeler takes for something else than the study's words.
  ClassProbabilities withoutStrangers() const {
    std::vector<double> sums(instances_.size(), 0), counts(instances_.size(), 0);
    const auto& instances = gathered_.training.instances;
    for (std::size_t i = 0; i < instances.size(); ++i) {
      sums[static_cast<std::size_t>(instances[i])] += shares_.mass[i];
      ++counts[static_cast<std::size_t>(instances[i])];
    }
    ClassProbabilities known{DescriptorMatrix(shares_.shares.labels()), shares_.mass};
    const std::vector<float> nothing(shares_.shares.labels(), 0);
    for (std::size_t i = 0; i < instances.size(); ++i) {
      const auto instance = static_cast<std::size_t>(instances[i]);
      known.shares.append(sums[instance] < options_.leastMass * counts[instance] ? DescriptorView(nothing)
                                                                                 : shares_.shares.row(i));
    }
    return known;
  }

  void count() {
    const std::size_t words = study_.words.size();
    const ObjectTraining& training = gathered_.training;
    gathered_.samples.assign(words, 0);
    std::vector<std::set<int>> instances(words);
    for (std::size_t i = 0; i < training.words.size(); ++i) {
      if (training.words[i] < 0) {
        ++gathered_.unnamed;
        continue;
      }
      const auto word = static_cast<std::size_t>(training.words[i]);
      ++gathered_.samples[word];
      instances[word].insert(training.instances[i]);
      gathered_.checked += truths_[i] >= 0 ? 1 : 0;
      gathered_.right += truths_[i] == training.words[i] ? 1 : 0;
    }
    for (const auto& of : instances) gathered_.instances.push_back(of.size());
  }

  void requireNames() const {
    const ObjectTraining& training = gathered_.training;
    if (gathered_.unnamed < training.words.size()) return;
    std::vector<std::pair<double, std::string>> often;
    for (const auto& [label, sum] : often_) often.emplace_back(-sum, label);
    std::ranges::sort(often);
    std::string mostly;
    for (std::size_t i = 0; i < std::min<std::size_t>(often.size(), 2); ++i)
      mostly += fmt::format("{}\"{}\"", i == 0 ? "" : " and ", often[i].second);
    throw Error(fmt::format(
        "not one of {} views is named by a word of the study: the labeler says {:.1f} % about these words{}, "
        "and most often {}; give the words labels that it says{}",
        training.words.size(), 100 * gathered_.mass,
        options_.leastMass > 0 ? fmt::format(", where a mass of {} is asked for", options_.leastMass) : "",
        mostly, options_.leastMass > 0 ? ", or ask for less mass" : ""));
  }

  const TargetClasses& study_;
  const TrainingOptions& options_;
  bool labeled_;
  TrainingSet gathered_{{study_, options_.shape, noShapes(options_.shape), {}, {}, "", {}}, {}, {}};
  ClassProbabilities shares_{DescriptorMatrix(study_.words.size()), {}};
  std::vector<int> truths_;
  std::map<std::string, double> often_;  // what the labeler says of all views together
  std::string stranger_;                 // a view without words beside a name that has some
  std::map<std::tuple<std::size_t, std::string, std::string>, int> instances_;
};

}  // namespace

TrainingSet gatherTraining(std::span<const LabeledViews> sources, const TargetClasses& study,
                           const TrainingOptions& options, Progress& progress,
                           std::vector<std::string>* problems) {
  if (!(options.leastMass >= 0 && options.leastMass <= 1))
    throw Error(fmt::format("a least mass of {} is none; it is a share, 0 to 1", options.leastMass));
  const bool labeled = !sources.empty() && sources.front().words.has_value();
  const std::string labeler = labeled ? sources.front().words->model : "";
  for (const LabeledViews& source : sources) {
    if (source.words.has_value() != labeled)
      throw Error(fmt::format("{} has words and {} has none; label both, or learn the true names of both",
                              (labeled ? sources.front() : source).views->name(),
                              (labeled ? source : sources.front()).views->name()));
    if (labeled && source.words->model != labeler)
      throw Error(fmt::format("{} was labeled by {}, but {} by {}; label both by one", source.views->name(),
                              source.words->model, sources.front().views->name(), labeler));
  }
  requireSplit(sources, options.split);
  TrainingSetBuilder gathering(study, options, labeled);
  for (std::size_t i = 0; i < sources.size(); ++i) gathering.add(sources[i], i, progress, problems);
  return gathering.finish(labeler, progress);
}

std::vector<std::string> categoriesOf(std::span<const LabeledViews> sources) {
  std::set<std::string> categories;
  for (const LabeledViews& source : sources)
    for (std::size_t i = 0; i < source.views->size(); ++i) categories.insert(source.views->view(i).category);
  categories.erase("");
  return {categories.begin(), categories.end()};
}

}  // namespace estancia
