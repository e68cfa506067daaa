// estancia label: images → words, printed, or kept in a file that other commands take instead of images.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "labeling.hpp"

namespace estancia::apps {
namespace {

using report::counted;
using Json = nlohmann::ordered_json;

struct LabelArguments {
  explicit LabelArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  ModelArguments model;
  DeclaredOptions declared;
  std::string output;
  std::size_t words = 10;
  bool overwrite = false, json = false;
};

/// The best words of each image (thesis Fig. 3.1), as they come.
void printWords(const LabelArguments& arguments) {
  Labeling labeling(arguments.sequence, arguments.model);
  const bool one = labeling.sequence().size() == 1;
  labeling.forEach(0, one ? "" : "labeling", [&](const LabeledFrame& frame) {
    const std::string& name = labeling.sequence().frame(frame.index).name;
    Json labels = Json::array();
    std::string line = printable(name) + ":";
    for (const std::size_t label : bestLabels(frame.descriptor, arguments.words)) {
      const std::string& word = labeling.vocabulary()[label];
      const double probability = frame.descriptor[label];
      if (probability <= 0) break;  // missing, as all that follow
      labels.push_back({{"label", word}, {"probability", probability}});
      const std::string shown = printable(one ? word : shortLabel(word));
      line += one ? fmt::format("\n  {:.3f}  {}", probability, shown)
                  : fmt::format("{} {} {:.2f}", labels.size() > 1 ? "," : "", shown, probability);
    }
    if (arguments.json)
      print(Json{{"image", name}, {"labels", labels}});
    else
      fmt::print("{}\n", line);
  });
}

void run(const LabelArguments& arguments) {
  if (arguments.output.empty()) return printWords(arguments);
  requireDescriptorFile(arguments.output);
  for (const auto& file : descriptorFilesOf(arguments.output))
    requireReplaceable(file, arguments.overwrite, nullptr, "label file");
  Labeling labeling(arguments.sequence, arguments.model);
  DescriptorSequence recording{
      labeling.vocabulary(), labeling.identity(), {}, DescriptorMatrix(labeling.vocabulary().size())};
  recording.descriptors.reserve(labeling.sequence().size());
  std::size_t skipped = 0;
  try {
    skipped = labeling.forEach(0, "labeling", [&](const LabeledFrame& frame) {
      recording.frames.push_back(labeling.sequence().frame(frame.index));
      recording.descriptors.append(frame.descriptor);
    });
  } catch (const Interrupted& e) {
    if (arguments.model.noCache) throw;
    throw Interrupted(fmt::format("{}; their labels are kept in the cache: run it again to go on", e.what()));
  }
  writeDescriptors(recording, arguments.output);
  if (recording.vocabulary.layout().parts.size() > 1 && !arguments.output.ends_with(".labels"))
    spdlog::warn(
        "{} holds the words of several models side by side, but not which are whose; maps are better made of "
        "a .labels file",
        arguments.output);
  if (arguments.json)
    print({{"labels", arguments.output},
           {"frames", recording.frames.size()},
           {"skipped", skipped},
           {"words", recording.vocabulary.size()},
           {"model", recording.model},
           {"remembered", labeling.remembered()}});
  else
    fmt::print("{}: {}, {} ({} from the cache)\n", printable(arguments.output),
               counted(recording.frames.size(), "frame"), counted(recording.vocabulary.size(), "word"),
               counted(labeling.remembered(), "frame"));
}

}  // namespace

void addLabelCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("label", "Label a sequence of images, for later commands or other programs");
  auto arguments = std::make_shared<LabelArguments>(*command);
  arguments->sequence.addTo(arguments->declared);
  addOutputOption(*command, arguments->output,
                  "NAME.labels (taken instead of the images by every command), or NAME.csv or NAME.npy; "
                  "without it the best words of each image are printed");
  command->add_option("--words", arguments->words, "Print so many words of an image")
      ->capture_default_str()
      ->check(CLI::PositiveNumber)
      ->excludes("--output");
  arguments->model.addTo(arguments->declared, "The model that labels the images");
  addOverwriteOption(*command, arguments->overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia label photo.jpg\n"
              "  estancia label ~/photos -o images.labels\n"
              "  estancia map images.labels -o home.estancia\n"
              "  estancia label images.labels -o images.csv");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
