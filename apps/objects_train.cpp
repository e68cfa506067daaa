// estancia objects train: shapes learned by the names that a labeler, or a data set, gives.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <set>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/object_samples.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/report/text.hpp"
#include "objects.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct Arguments {
  std::vector<std::string> views, labels;
  ObjectViewsOptions type;
  std::string study, output, naming = "voted", prior = "uniform";
  TrainingOptions options;
  bool truth = false, overwrite = false, json = false;
};

/// VIEWS with their words.
struct Sources {
  std::vector<std::unique_ptr<ObjectViews>> opened;
  std::vector<LabeledViews> labeled;
};

DescriptorSequence wordsFor(const Arguments& a, std::size_t source) {
  if (!a.labels.empty()) return readDescriptors(a.labels[source]);
  const std::string& views = a.views[source];
  if (!isObjectSamples(views))
    throw Error(fmt::format(
        "{} is no folder of `estancia objects collect`, which has words of its own: run `estancia "
        "objects label {} -o NAME.labels`, then give --labels NAME.labels, or learn the true names "
        "by --truth",
        views, views));
  if (!std::filesystem::exists(wordsOf(views)))
    throw Error(fmt::format(
        "{} has no words yet: run `estancia objects label {}`, or say where they are by --labels, "
        "or learn the true names by --truth",
        views, views));
  return readDescriptors(wordsOf(views));
}

/// A thing that is there twice would be two instances, and stand on both sides of what is held out.
void requireDifferent(const std::vector<std::string>& views) {
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::error_code none; std::filesystem::equivalent(views[i], views[j], none))
        throw Error(fmt::format("{} and {} are the same views; give them once", views[j], views[i]));
}

Sources open(const Arguments& a) {
  requireDifferent(a.views);
  if (!a.labels.empty() && a.labels.size() != a.views.size())
    throw Error(fmt::format("{} VIEWS need as many --labels, in the same order; there are {}", a.views.size(),
                            a.labels.size()));
  Sources sources;
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    sources.opened.push_back(openObjectViews(a.views[i], a.type));
    for (const std::string& warning : sources.opened.back()->warnings()) spdlog::warn("{}", warning);
    LabeledViews& labeled = sources.labeled.emplace_back();
    labeled.views = sources.opened.back().get();
    if (!a.truth) labeled.labels = wordsFor(a, i);
  }
  return sources;
}

TargetClasses targetsOf(const Arguments& a, const Sources& sources) {
  if (!a.study.empty()) return readTargetClasses(a.study);
  if (!a.truth)
    throw Error(
        "the words to learn are missing: give a study, a TOML file with a table [classes.NAME] each, by "
        "--study");
  const auto categories = categoriesOf(sources.labeled);
  if (categories.empty())
    throw Error(
        fmt::format("{}: nobody says what these things are, so there are no true names to learn; label "
                    "them, or fill in the column `category` of samples.csv",
                    a.views.front()));
  return targetClassesOf(categories);
}

/// Labels that are spelled as no labeler spells them are no error, as their word has others.
void warnOfLabels(const TargetClasses& targets, const Sources& sources) {
  std::set<std::string> told;
  for (const LabeledViews& labeled : sources.labeled)
    if (labeled.labels)
      for (const std::string& sentence : unknownLabels(targets, labeled.labels->vocabulary))
        if (told.insert(sentence).second) spdlog::warn("{}", sentence);
}

Json jsonOf(const Arguments& a, const TrainingSet& g, const ObjectModel& model) {
  Json words = Json::array();
  for (std::size_t w = 0; w < model.targets().classes.size(); ++w) {
    Json word{
        {"word", model.targets().classes[w].name}, {"views", g.samples[w]}, {"instances", g.instances[w]}};
    word["prior"] = model.prior().empty() ? Json() : Json(model.prior()[w]);
    word["held_out_accuracy"] = model.heldOutAccuracy()[w] < 0 ? Json() : Json(model.heldOutAccuracy()[w]);
    words.push_back(word);
  }
  Json json{
      {"model", a.output},
      {"names", a.truth ? "true" : a.naming},
      {"labeler", model.labeler()},
      {"words", words},
      {"coverage", g.coverage},
      {"left_out",
       {{"flat", g.flat}, {"at_border", g.atBorder}, {"unlabeled", g.unlabeled}, {"rejected", g.rejected}}},
      {"choice", model.choice()}};
  json["pseudo_label_accuracy"] =
      a.truth || g.comparable == 0 ? Json()
                                   : Json(static_cast<double>(g.correct) / static_cast<double>(g.comparable));
  return json;
}

void tell(const Arguments& a, const TrainingSet& g, const ObjectModel& model) {
  const auto percent = [](double share) {
    return share < 0 ? std::string("?") : fmt::format("{:.0f} %", 100 * share);
  };
  std::size_t views = 0;
  for (const std::size_t count : g.samples) views += count;
  fmt::print("{}: {} of {}, named by {}\n", a.output, counted(model.targets().classes.size(), "word"),
             counted(views, "view"),
             a.truth
                 ? "their true categories"
                 : fmt::format("{} ({})", model.labeler().substr(0, model.labeler().find(' ')), a.naming));
  fmt::print("  {:<24} {:>6} {:>7} {:>6} {:>10}\n", "word", "views", "things", "prior", "held out");
  for (std::size_t w = 0; w < model.targets().classes.size(); ++w)
    fmt::print("  {:<24} {:>6} {:>7} {:>6} {:>10}\n", model.targets().classes[w].name, g.samples[w],
               g.instances[w], model.prior().empty() ? "" : percent(model.prior()[w]),
               percent(model.heldOutAccuracy()[w]));
  if (!a.truth) fmt::print("{} of what the labeler says is about these words\n", percent(g.coverage));
  if (!a.truth && g.comparable > 0)
    fmt::print("{} of {} whose category is known are named rightly\n",
               percent(static_cast<double>(g.correct) / static_cast<double>(g.comparable)),
               counted(g.comparable, "view"));
  if (g.flat + g.atBorder + g.unlabeled + g.rejected > 0)
    fmt::print("left out: {} flat, {} cut by the border, {} without words, {} without a name\n", g.flat,
               g.atBorder, g.unlabeled, g.rejected);
  fmt::print("{}\n", model.choice());
}

void run(Arguments& a) {
  if (a.output.empty()) throw Error("the model has no name; give -o one, such as kitchen.objects");
  requireReplaceable(a.output, a.overwrite, isObjectModel, "model of objects");
  const Sources sources = open(a);
  const TargetClasses targets = targetsOf(a, sources);
  a.options.pseudoLabels = getPseudoLabeling(a.naming);
  a.options.correctPrior = a.prior == "uniform";
  a.options.shape.threads = a.options.classifier.threads;
  warnOfLabels(targets, sources);
  const auto progress = makeStderrProgress();
  std::vector<std::string> problems;
  const TrainingSet gathered = gatherTraining(sources.labeled, targets, a.options, *progress, &problems);
  for (const std::string& problem : problems) spdlog::warn("left out: {}", problem);
  const ObjectModel model = trainObjectModel(gathered.training, a.options.classifier, *progress);
  writeObjectModel(model, a.output);
  if (a.json)
    print(jsonOf(a, gathered, model));
  else
    tell(a, gathered, model);
}

template <class Named>
std::string explained(const std::string& what, const std::vector<Named>& known) {
  std::string text = what;
  for (const auto& [name, explanation] : known) text += fmt::format("\n{} ({})", name, explanation);
  return text;
}

template <class Named>
std::vector<std::string> namesIn(const std::vector<Named>& known) {
  std::vector<std::string> names;
  names.reserve(known.size());
  for (const auto& [name, explanation] : known) names.push_back(name);
  return names;
}

}  // namespace

void addObjectsTrain(CLI::App& objects) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = objects.add_subcommand("train", "Learn the shapes of a study's words");
  command
      ->add_option(
          "VIEWS", a->views,
          "Folders of `estancia objects collect`, labeled by `estancia objects label`, or of another "
          "data set")
      ->required();
  command->add_option(
      "--study", a->study,
      "The words, and what labelers and data sets call them: TOML, a table [classes.NAME] each; "
      "with --truth by default the categories");
  command->add_option("-o,--output", a->output, "The model, NAME.objects")->required();
  command->add_option("--names", a->naming, explained("How words become names:", pseudoLabelings()))
      ->check(CLI::IsMember(namesIn(pseudoLabelings())))
      ->capture_default_str();
  command
      ->add_option("--prior", a->prior,
                   "How frequent the words are: uniform (the labeler's answers are divided by how often it "
                   "gives each) or none (answers as they are, as in the thesis)")
      ->check(CLI::IsMember({"uniform", "none"}))
      ->capture_default_str();
  command
      ->add_option("--min-coverage", a->options.minCoverage,
                   "Give no name to things of whose images the labeler says less than this share about the "
                   "study's words: they are something else")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  CLI::Option* truth = command->add_flag(
      "--truth", a->truth, "Learn the true categories of the views instead of a labeler's words");
  for (const char* said : {"--names", "--prior", "--min-coverage"})
    truth->excludes(command->get_option(said));
  command
      ->add_option("--labels", a->labels,
                   "The words of each of VIEWS, in order; default: words.labels in the folder")
      ->allow_extra_args(false)
      ->excludes("--truth");
  command->add_option("--type", a->type.type,
                      explained("How to read VIEWS: auto (finds out by itself)", objectViewTypes()));
  command->add_option("--split", a->options.split, "Only the views of this part of the data set");
  command->add_flag("--all", a->options.allViews,
                    "Learn from flat views and from those cut by the border, too");
  const auto learning = "Learning";
  command
      ->add_option("--classifier", a->options.classifier.type, explained("What learns:", classifierTypes()))
      ->check(CLI::IsMember(namesIn(classifierTypes())))
      ->capture_default_str()
      ->group(learning);
  command->add_flag("--balanced", a->options.classifier.balanced, "Each word counts alike")->group(learning);
  command->add_flag("--size", a->options.shape.size, "Learn how large things are, too")->group(learning);
  command->add_option("--seed", a->options.classifier.seed, "Of whatever is random")
      ->capture_default_str()
      ->group(learning);
  command->add_option("--threads", a->options.classifier.threads, "Threads; default: one a usable core")
      ->check(CLI::Range(0, 1024))
      ->group(learning);
  command->add_flag("--overwrite", a->overwrite, "Replace an existing model");
  addJsonOption(*command, a->json);
  addExamples(
      *command,
      "  estancia objects train things --study kitchen.toml -o kitchen.objects\n"
      "  estancia objects train monday tuesday --study kitchen.toml -o kitchen.objects --size\n"
      "  estancia objects train things --study kitchen.toml -o thesis.objects --names top --prior none\n"
      "  estancia objects train ~/restaurant --truth -o restaurant.objects");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
