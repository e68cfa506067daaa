// estancia objects: things that stand about, gathered and labeled.
#include "objects.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <map>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/object_samples.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/label/record.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/object_crops.hpp"
#include "estancia/report/text.hpp"
#include "labeling.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using report::counted;

// ---- collect

struct CollectArguments {
  SequenceArguments sequence;
  std::string output;
  CollectOptions options;
  bool overwrite = false, json = false;
};

/// What should make people look at their sequence again.
void warnOf(const Collected& c) {
  if (c.withoutPlane > 0)
    spdlog::warn(
        "{} of {} frames show no table, wall or floor that things could be told from; is --depth-scale "
        "right, and is most of the depth there?",
        c.withoutPlane, c.frames);
  if (c.huge > 0)
    spdlog::warn("{} frames hold a thing of more than half of their pixels: no single one, or too near",
                 c.huge);
}

void collect(const CollectArguments& a) {
  const auto sequence = a.sequence.open();
  requireClusterable(*sequence);
  const auto progress = makeStderrProgress();
  std::vector<std::string> problems;
  CollectOptions options = a.options;
  options.strict = a.sequence.strict;
  options.replace = a.overwrite;
  const Collected c = collectObjects(*sequence, a.output, options, *progress, &problems);
  for (const std::string& problem : problems) spdlog::warn("skipped: {}", problem);
  warnOf(c);
  if (a.json)
    print({{"samples", a.output},
           {"frames", c.frames},
           {"unread", c.unread},
           {"without_plane", c.withoutPlane},
           {"without_cluster", c.withoutCluster},
           {"huge", c.huge},
           {"views", c.samples},
           {"instances", c.instances},
           {"flat", c.flat},
           {"at_border", c.atBorder},
           {"left_out", c.full}});
  else if (c.samples == 0)
    fmt::print("Nothing stands about in the {} of {}\n", counted(c.frames - c.unread, "frame"),
               sequence->name());
  else
    fmt::print("{}: {} of {} in {}; {} flat, {} cut by the border{}\n", a.output, counted(c.samples, "view"),
               counted(c.instances, "thing"), counted(c.frames - c.unread, "frame"), c.flat, c.atBorder,
               c.full > 0 ? fmt::format("; {} more of things that had {}", c.full, a.options.maxViews) : "");
  if (c.samples == 0) throw NoAnswer{};
}

// ---- label

struct LabelArguments {
  std::string views, output;
  ObjectViewsOptions type;
  CropOptions patches;
  ModelArguments model;
  bool overwrite = false, json = false;
};

std::string outputOf(const LabelArguments& a) {
  if (!a.output.empty()) return a.output;
  if (!isObjectSamples(a.views))
    throw Error(
        fmt::format("{} is no folder of `estancia objects collect`, so say where the words go: "
                    "-o NAME.labels",
                    a.views));
  return labelFileOf(a.views).string();
}

void label(const LabelArguments& a) {
  const auto views = openObjectViews(a.views, a.type);
  for (const std::string& warning : views->warnings()) spdlog::warn("{}", warning);
  if (isObjectSamples(a.views) && a.patches.margin > maxCollectedMargin)
    throw Error(fmt::format(
        "{} was collected with {} of each thing's longer side around it; --margin is at most that", a.views,
        maxCollectedMargin));
  const std::string output = outputOf(a);
  requireDescriptorFile(output);
  for (const auto& file : descriptorFilesOf(output)) {
    requireNoData(file, {});
    requireReplaceable(
        file, a.overwrite, [](const fs::path&) { return true; }, "words");
  }
  const auto patches = cropsOf(*views, a.patches);
  const auto labeler = a.model.open();
  const auto cache = a.model.noCache ? nullptr : std::make_unique<LabelCache>();
  const auto progress = makeStderrProgress();
  std::size_t remembered = 0, skipped = 0;
  const DescriptorSequence words =
      labelAll(*patches, *labeler, "labeling", cache.get(), *progress, [&](const LabeledFrame& frame) {
        if (!frame.labeled()) {
          ++skipped;
          spdlog::warn("skipped: {}", frame.problem);
        }
        remembered += frame.remembered ? 1 : 0;
      });
  if (cache && !cache->problem().empty()) spdlog::warn("{}", cache->problem());
  writeDescriptors(words, output);
  if (a.json)
    print({{"labels", output},
           {"views", words.frames.size()},
           {"skipped", skipped},
           {"words", words.vocabulary.size()},
           {"model", words.model},
           {"remembered", remembered}});
  else
    fmt::print("{}: {}, {} ({} from the cache)\n", output, counted(words.frames.size(), "view"),
               counted(words.vocabulary.size(), "word"), counted(remembered, "view"));
}

}  // namespace

void addSequenceWithDepth(CLI::App& command, SequenceArguments& sequence) {
  sequence.addTo(command);
  sequence.addDepthTo(command);
  // Tours of panoramas have no depth, and --views is how many of one thing are gathered.
  for (const auto* option : {"--views", "--fov", "--turn", "--ev", "--rounds"})
    command.remove_option(command.get_option(option));
}

void addPatchOptions(CLI::App& command, CropOptions& patches) {
  using Background = CropOptions::Background;
  static const std::map<std::string, Background> backgrounds = {
      {"kept", Background::kept}, {"gray", Background::gray}, {"mean", Background::mean}};
  command
      .add_option("--margin", patches.margin,
                  "What the labeler sees around a thing, in shares of its longer side")
      ->check(CLI::Range(0., 4.))
      ->capture_default_str();
  command
      .add_option("--background", patches.background,
                  "What is behind a thing for the labeler: kept (what the image shows), gray, mean (the "
                  "thing's mean color); default: kept")
      ->transform(CLI::CheckedTransformer(backgrounds).description(""));
}

void addObjectsCollect(CLI::App& objects) {
  auto a = std::make_shared<CollectArguments>();
  CLI::App* command =
      objects.add_subcommand("collect", "Gather images and clouds of the things in a sequence with depth");
  addSequenceWithDepth(*command, a->sequence);
  command->add_option("-o,--output", a->output, "A new folder: samples.csv, images/ and clouds/")->required();
  command->add_option("--first", a->options.first, "The frame to begin with, from 0");
  command->add_option("--frames", a->options.maxFrames, "Look at so many frames; default: all")
      ->check(positive());
  command->add_option("--every", a->options.every, "Look at every so-many-th frame only")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--views", a->options.maxViews, "Most views of one thing")
      ->check(positive())
      ->capture_default_str();
  command
      ->add_option("--least", a->options.clusters.minPoints,
                   "Pixels of a thing at least, in an image with a focal length of 525")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--threads", a->options.clusters.threads, "Threads; default: one a usable core")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--overwrite", a->overwrite, "Replace the samples in an existing folder");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia objects collect ~/kitchen -o things\n"
              "  estancia objects collect tum/rgbd_dataset_freiburg1_desk -o things --every 5 --views 100");
  command->callback([a] { collect(*a); });
}

void addObjectsLabel(CLI::App& objects) {
  auto a = std::make_shared<LabelArguments>();
  CLI::App* command = objects.add_subcommand("label", "Let a labeler name the images of things");
  command->add_option("VIEWS", a->views, "A folder of `estancia objects collect`, or of another data set")
      ->required();
  std::string types = "How to read VIEWS: auto (finds out by itself)";
  for (const auto& [name, explanation] : objectViewTypes())
    types += fmt::format("; {} ({})", name, explanation);
  command->add_option("--type", a->type.type, types);
  command->add_option(
      "-o,--output", a->output,
      "NAME.labels, which holds all that the labeler says; default: words.labels in VIEWS, if "
      "it was collected");
  addPatchOptions(*command, a->patches);
  a->model.addTo(*command, "What labels the images");
  command->add_flag("--overwrite", a->overwrite, "Replace existing words");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia objects label things\n"
              "  estancia objects label ~/rgbd-dataset --model mobilenet-v2 -o washington.labels");
  command->callback([a] { label(*a); });
}

void addObjectsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "objects", "Things that name themselves: learn shapes by what a labeler says of their images");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia objects collect ~/kitchen -o things\n"
              "  estancia objects label things\n"
              "  estancia objects train things --study kitchen.toml -o kitchen.objects\n"
              "  estancia objects predict ~/kitchen-at-night --model kitchen.objects");
  addObjectsCollect(*command);
  addObjectsLabel(*command);
  addObjectsTrain(*command);
  addObjectsPredict(*command);
}

}  // namespace estancia::apps
