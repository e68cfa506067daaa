// estancia objects: samples of objects, collected and labeled.
// SPDX-License-Identifier: Apache-2.0
#include "objects.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/readers/object_samples.hpp"
#include "estancia/readers/object_views.hpp"
#include "labeling.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

namespace fs = std::filesystem;
using report::counted;

// ---- collect

struct CollectArguments {
  explicit CollectArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  std::string output;
  CollectOptions options;
  bool json = false;
  DeclaredOptions declared;
};

/// Warnings about a sequence that should be checked.
void warnOf(const Collected& c) {
  if (c.withoutPlane > 0)
    spdlog::warn(
        "{} of {} frames show no table, wall or floor that supports objects; is --depth-scale right, and is "
        "most of the depth there?",
        c.withoutPlane, c.frames);
  if (c.huge > 0)
    spdlog::warn("{} frames hold an object of more than half of their pixels: under-segmented, or too near",
                 c.huge);
}

void collect(const CollectArguments& a) {
  const auto sequence = a.sequence.open();
  requireClusterable(*sequence);
  const auto progress = makeStderrProgress();
  std::vector<std::string> problems;
  const Collected c = collectObjects(*sequence, a.output, a.options, *progress, &problems);
  Skipped skipped;
  for (const std::string& problem : problems) skipped.add(problem);
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
    fmt::print("No object was found in the {} of {}\n", counted(c.frames - c.unread, "frame"),
               sequence->name());
  else
    fmt::print("{}: {} of {} in {}; {} flat, {} cut by the border{}\n", printable(a.output),
               counted(c.samples, "view"), counted(c.instances, "object"),
               counted(c.frames - c.unread, "frame"), c.flat, c.atBorder,
               c.full > 0 ? fmt::format("; {} more of objects that had {}", c.full, a.options.maxViews) : "");
  if (c.samples == 0) throw NoAnswer{};
}

// ---- label

struct LabelViewsArguments {
  explicit LabelViewsArguments(CLI::App& command) : declared(command) {}
  std::string views, output;
  ObjectViewsOptions format;
  CropOptions crops;
  ModelArguments model;
  bool overwrite = false, json = false;
  DeclaredOptions declared;
};

std::string outputOf(const LabelViewsArguments& a) {
  if (!a.output.empty()) return a.output;
  if (!isObjectSamples(a.views))
    throw Error(
        ErrorCode::invalidOption,
        fmt::format("{} is no folder of `estancia objects collect`, so -o NAME.labels is needed", a.views));
  return labelFileOf(a.views).string();
}

void label(const LabelViewsArguments& a) {
  const auto views = openObjectViews(a.views, a.format);
  for (const std::string& warning : views->warnings()) spdlog::warn("{}", warning);
  if (isObjectSamples(a.views) && a.crops.margin > maxCollectedMargin)
    throw Error(ErrorCode::invalidOption,
                fmt::format("{} was collected with a margin of {}; --margin is at most that", a.views,
                            maxCollectedMargin));
  const std::string output = outputOf(a);
  requireDescriptorFile(output);
  for (const auto& file : descriptorFilesOf(output)) {
    requireNoData(file, {});
    requireReplaceable(
        file, a.overwrite, [](const fs::path&) { return true; }, "label file");
  }
  const auto crops = cropsOf(*views, a.crops);
  const auto labeler = a.model.open();
  const auto cache = a.model.noCache ? nullptr : std::make_unique<LabelCache>();
  LabelStreamOptions stream = a.model.stream;
  stream.cache = cache.get();
  const auto progress = makeStderrProgress();
  std::size_t remembered = 0;
  Skipped skipped;
  const DescriptorSequence labels =
      labelAll(*crops, *labeler, "labeling", stream, *progress, [&](const LabeledFrame& frame) {
        if (!frame.labeled()) skipped.add(frame.problem);
        remembered += frame.remembered ? 1 : 0;
      });
  if (cache && !cache->problem().empty()) spdlog::warn("{}", cache->problem());
  writeDescriptors(labels, output);
  if (a.json)
    print({{"labels", output},
           {"views", labels.frames.size()},
           {"skipped", skipped.count()},
           {"words", labels.vocabulary.size()},
           {"model", labels.model},
           {"remembered", remembered}});
  else
    fmt::print("{}: {}, {} ({} from the cache)\n", printable(output), counted(labels.frames.size(), "view"),
               counted(labels.vocabulary.size(), "word"), counted(remembered, "view"));
}

}  // namespace

void addObjectsCollect(CLI::App& objects) {
  CLI::App* command = objects.add_subcommand(
      "collect", "Collect images and point clouds of the objects in a sequence with depth");
  auto a = std::make_shared<CollectArguments>(*command);
  a->sequence.addTo(a->declared);
  SequenceArguments::addDepthTo(a->declared);
  command->add_option("-o,--output", a->output, "A new folder: samples.csv, images/ and clouds/")->required();
  a->declared.add(declare(a->options),
                  {"first", "every", "max-frames", "max-views", "clusters", "strict", "replace=overwrite"});
  a->declared.add(declare(a->options.clusters), {"min-points=min-pixels"});
  addJsonOption(*command, a->json);
  addExamples(
      *command,
      "  estancia objects collect ~/kitchen -o samples\n"
      "  estancia objects collect tum/rgbd_dataset_freiburg1_desk -o samples --every 5 --max-views 100");
  command->callback([a] { collect(*a); });
}

void addObjectsLabel(CLI::App& objects) {
  CLI::App* command = objects.add_subcommand("label", "Label the images of objects");
  auto a = std::make_shared<LabelViewsArguments>(*command);
  command->add_option("VIEWS", a->views, "A folder of `estancia objects collect`, or of another data set")
      ->required();
  a->declared.add(declare(a->format), {"type"});
  command
      ->add_option("-o,--output", a->output,
                   "NAME.labels, with all answers of the model\nDefault: words.labels in VIEWS, if it was "
                   "collected")
      ->type_name("FILE");
  a->declared.add(declare(a->crops), {"margin", "background"});
  a->model.addTo(a->declared, "The model that labels the images");
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia objects label samples\n"
              "  estancia objects label ~/rgbd-dataset --model mobilenet-v2 -o washington.labels");
  command->callback([a] { label(*a); });
}

void addObjectsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "objects", "Find objects and learn their shapes by the labels that a model gives their images");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia objects collect ~/kitchen -o samples\n"
              "  estancia objects label samples\n"
              "  estancia objects train samples --study kitchen.toml -o kitchen.objects\n"
              "  estancia objects predict ~/kitchen-at-night --object-model kitchen.objects");
  addObjectsCollect(*command);
  addObjectsLabel(*command);
  addObjectsTrain(*command);
  addObjectsPredict(*command);
  addObjectsList(*command);
  addObjectsName(*command);
  addObjectsDelete(*command);
}

}  // namespace estancia::apps
