// estancia objects train: a shape classifier, trained on the labels of images or on true categories.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <numeric>
#include <set>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/own_classes.hpp"
#include "estancia/objects/training_sources.hpp"
#include "estancia/words/installed_words.hpp"
#include "objects.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct ObjectsTrainArguments {
  explicit ObjectsTrainArguments(CLI::App& command) : declared(command) {}
  std::vector<std::string> views, labels;
  ObjectViewsOptions format;
  std::string study, output;
  TrainingOptions options;
  bool truth = false, overwrite = false, json = false;
  DeclaredOptions declared;
};

/// Without classes, the labels make their own.
TargetClasses targetsOf(const ObjectsTrainArguments& a, const TrainingSources& sources) {
  if (!a.study.empty()) return readTargetClasses(a.study);
  return a.truth ? targetClassesOf(sources) : TargetClasses{};
}

/// A person's words for classes that the labelers have no label for; reports which labels stand for them.
TargetClasses understood(TargetClasses targets, const TrainingSources& sources) {
  std::vector<std::string> told;
  for (const LabeledViews& labeled : sources.labeled)
    if (labeled.labels)
      targets = withLabelKinds(targets, labeled.labels->vocabulary, installedWordGraph, &told);
  for (const std::string& sentence : told) spdlog::info("{}", sentence);
  return targets;
}

/// A label that the labeler does not know is no error, as its class has others.
void warnOfLabels(const TargetClasses& targets, const TrainingSources& sources) {
  std::set<std::string> warned;
  for (const LabeledViews& labeled : sources.labeled)
    if (labeled.labels)
      for (const std::string& sentence :
           unknownLabels(targets, labeled.labels->vocabulary, installedWordGraph))
        if (warned.insert(sentence).second) spdlog::warn("{}", sentence);
}

std::string pseudoLabelsOf(const ObjectsTrainArguments& a) {
  return a.truth ? "true" : pseudoLabelings()[static_cast<std::size_t>(a.options.pseudoLabels)].name;
}

Json jsonOf(const OwnClasses& own) {
  Json leftOut = Json::array();
  for (const SureWord& word : own.leftOut)
    leftOut.push_back({{"word", word.name},
                       {"objects", word.objects},
                       {"views", word.views},
                       {"recognized", word.recognized},
                       {"chance", word.chance}});
  return {{"unsure", own.unsure}, {"left_out", leftOut}};
}

/// "chair: folding chair, rocking chair", and what is no class.
void printOwnClasses(const OwnClasses& own, const TargetClasses& targets) {
  for (const TargetClasses::Class& target : targets.classes)
    if (target.labels.size() > 1) fmt::print("{}: {}\n", target.name, fmt::join(target.labels, ", "));
  fmt::print("no class: {}\n", leftOutOf(own));
}

Json jsonOf(const ObjectsTrainArguments& a, const TrainingSet& set, const ObjectModel& model) {
  Json classes = Json::array();
  for (std::size_t c = 0; c < model.targets().classes.size(); ++c) {
    Json entry{{"class", model.targets().classes[c].name},
               {"labels", model.targets().classes[c].labels},
               {"views", set.samples[c]},
               {"instances", set.instances[c]}};
    entry["prior"] = model.prior().empty() ? Json() : Json(model.prior()[c]);
    entry["held_out_accuracy"] = model.heldOutAccuracy()[c] < 0 ? Json() : Json(model.heldOutAccuracy()[c]);
    classes.push_back(entry);
  }
  Json json{{"model", a.output},
            {"pseudo_labels", pseudoLabelsOf(a)},
            {"labeler", model.labeler()},
            {"classes", classes},
            {"coverage", set.coverage},
            {"left_out",
             {{"flat", set.flat},
              {"at_border", set.atBorder},
              {"unlabeled", set.unlabeled},
              {"rejected", set.rejected}}},
            {"choice", model.choice()}};
  json["own_classes"] = set.own ? jsonOf(*set.own) : Json();
  json["pseudo_label_accuracy"] =
      a.truth || set.comparable == 0
          ? Json()
          : Json(static_cast<double>(set.correct) / static_cast<double>(set.comparable));
  return json;
}

void printText(const ObjectsTrainArguments& a, const TrainingSet& set, const ObjectModel& model) {
  const auto percent = [](double share) {
    return share < 0 ? std::string("?") : fmt::format("{:.0f} %", 100 * share);
  };
  const std::size_t views = std::accumulate(set.samples.begin(), set.samples.end(), std::size_t{0});
  const auto& classes = model.targets().classes;
  fmt::print(
      "{}: {} classes of {}, labeled by {}\n", printable(a.output), classes.size(), counted(views, "view"),
      a.truth
          ? "their true categories"
          : fmt::format("{} ({})", model.labeler().substr(0, model.labeler().find(' ')), pseudoLabelsOf(a)));
  fmt::print("  {:<24} {:>6} {:>7} {:>6} {:>10}\n", "class", "views", "objects", "prior", "held out");
  for (std::size_t c = 0; c < classes.size(); ++c)
    fmt::print("  {:<24} {:>6} {:>7} {:>6} {:>10}\n", classes[c].name, set.samples[c], set.instances[c],
               model.prior().empty() ? "" : percent(model.prior()[c]), percent(model.heldOutAccuracy()[c]));
  if (set.own) printOwnClasses(*set.own, model.targets());
  if (!a.truth) fmt::print("{} of the labeler's answers are these classes\n", percent(set.coverage));
  if (!a.truth && set.comparable > 0)
    fmt::print("{} of {} with a known category have the correct pseudo-label\n",
               percent(static_cast<double>(set.correct) / static_cast<double>(set.comparable)),
               counted(set.comparable, "view"));
  if (set.flat + set.atBorder + set.unlabeled + set.rejected > 0)
    fmt::print("left out: {} flat, {} cut by the border, {} without labels, {} without a class\n", set.flat,
               set.atBorder, set.unlabeled, set.rejected);
  fmt::print("{}\n", model.choice());
}

void run(const ObjectsTrainArguments& a) {
  if (a.output.empty())
    throw Error(ErrorCode::invalidOption, "the model has no name; give one by -o, such as kitchen.objects");
  requireReplaceable(a.output, a.overwrite, isObjectModel, "object model");
  const TrainingSources sources = openTrainingSources(
      a.views, a.labels, a.truth ? LabelSource::categories : LabelSource::files, a.format);
  for (const auto& views : sources.views)
    for (const std::string& warning : views->warnings()) spdlog::warn("{}", warning);
  const TargetClasses asked = targetsOf(a, sources), targets = understood(asked, sources);
  warnOfLabels(asked, sources);
  const auto progress = makeStderrProgress();
  std::vector<std::string> problems;
  const TrainingSet set = gatherTraining(sources.labeled, targets, a.options, *progress, &problems);
  Skipped skipped("left out");
  for (const std::string& problem : problems) skipped.add(problem);
  const ObjectModel model = trainObjectModel(set.training, a.options.classifier, *progress);
  writeObjectModel(model, a.output);
  if (a.json)
    print(jsonOf(a, set, model));
  else
    printText(a, set, model);
}

}  // namespace

void addObjectsTrain(CLI::App& objects) {
  CLI::App* command = objects.add_subcommand("train", "Train a classifier of object shapes");
  auto a = std::make_shared<ObjectsTrainArguments>(*command);
  command
      ->add_option(
          "VIEWS", a->views,
          "Folders of `estancia objects collect`, labeled by `estancia objects label`, or of another "
          "data set")
      ->required();
  a->declared.add(declare(a->format), {"type"});
  command
      ->add_option(
          "--study", a->study,
          "The target classes, and their names at labelers and in data sets: TOML with tables "
          "[classes.NAME]\nDefault: the words that several objects surely have and their shapes confirm; "
          "with --truth, the categories")
      ->type_name("FILE");
  addOutputOption(*command, a->output, "The model, NAME.objects")->required();
  command
      ->add_option(
          "--recorded-labels", a->labels,
          "The label file of each of VIEWS, in order; may be given repeatedly\nDefault: words.labels "
          "in the folder")
      ->type_name("FILE")
      ->allow_extra_args(false);
  CLI::Option* truth =
      command->add_flag("--truth", a->truth, "Learn the true categories of the views instead of labels");
  a->declared.add(declare(a->options),
                  {"pseudo-labels", "correct-prior", "min-coverage", "split", "all-views", "shape.size",
                   "classifier.type=classifier", "classifier.balanced", "classifier.seed"});
  for (const char* labeling :
       {"--recorded-labels", "--pseudo-labels", "--no-correct-prior", "--min-coverage"})
    truth->excludes(command->get_option(labeling));
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia objects train samples -o kitchen.objects\n"
              "  estancia objects train samples --study kitchen.toml -o kitchen.objects\n"
              "  estancia objects train monday tuesday --study kitchen.toml -o kitchen.objects --size\n"
              "  estancia objects train samples --study kitchen.toml -o thesis.objects --pseudo-labels top "
              "--no-correct-prior\n"
              "  estancia objects train ~/restaurant --truth -o restaurant.objects");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
