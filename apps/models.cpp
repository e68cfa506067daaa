// estancia models: the networks that label.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "common.hpp"
#include "convert/model_folder.hpp"
#include "convert/quantize_model.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/label/catalog.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_senses.hpp"
#include "labeling.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

void list(bool json) {
  const auto models = installedModels();
  for (const InstalledModel& model : models) {
    const std::string name = model.folder.filename().string();
    if (json) {
      print({{"name", name},
             {"folder", model.folder.string()},
             {"type", model.spec ? model.spec->type : ""},
             {"engines", model.spec ? enginesFor(*model.spec) : std::vector<std::string>{}},
             {"license", model.spec ? model.spec->license : ""},
             {"problem", model.problem}});
    } else if (model.spec) {
      fmt::print("{:<24} {:<10} {}{}\n", name, model.spec->type, model.spec->license,
                 name == defaultModel ? " (default)" : "");
    } else {
      fmt::print("{:<24} broken: {}\n", name, model.problem);
    }
  }
  if (json) return;
  fmt::print("Engines at hand: {}\n", fmt::join(engines(), ", "));
  if (models.empty())
    fmt::print(
        "No models yet in {}; estancia-fetch (script/bootstrap in the source) fetches the default one, "
        "`models get` others.\n",
        modelHome().string());
}

/// The labels whose meaning WordNet leaves in doubt: "mouse (mouse, 1.00)"; those that it does not know:
/// "xyzzy (?)".
std::vector<std::string> doubtfulLabels(const ModelCheck& check) {
  const WordGraph* graph = installedWordGraph();
  std::vector<std::string> doubtful;
  if (graph == nullptr || check.labelNames.empty()) return doubtful;
  const std::vector<LabelSense> senses = findLabelSenses(*graph, Vocabulary(check.labelNames));
  for (std::size_t i = 0; i < senses.size(); ++i)
    if (senses[i].senses.empty())
      doubtful.push_back(fmt::format("{} (?)", shortLabel(check.labelNames[i])));
    else if (senses[i].isDoubtful)
      doubtful.push_back(fmt::format("{} ({}, {:.2f})", shortLabel(check.labelNames[i]),
                                     graph->name(senses[i].senses.front().synset),
                                     senses[i].senses.front().probability));
  return doubtful;
}

void report(const ModelCheck& check, bool json) {
  const std::vector<std::string> doubtful = doubtfulLabels(check);
  if (json)
    return print({{"name", check.spec.name},
                  {"identity", check.identity},
                  {"labels", check.labels},
                  {"digests_checked", check.digests},
                  {"ms_per_image", check.millisecondsPerImage},
                  {"doubtful_labels", doubtful}});
  fmt::print("{}: works; {} labels, {:.1f} ms an image, {} file digests checked\n", check.spec.name,
             check.labels, check.millisecondsPerImage, check.digests);
  if (!doubtful.empty())
    fmt::print("{} of unsure meaning when asked in words (what WordNet takes them for, how probably): {}\n",
               report::counted(doubtful.size(), "label"), fmt::join(doubtful, ", "));
}

void showCatalog(bool json) {
  const Catalog catalog = Catalog::load();
  if (!json) fmt::print("{:<20} {:>7} {:>6}  {:<9} {:<9} {}\n", "", "MB", "words", "checksum", "", "license");
  for (const auto& [name, model] : catalog.models()) {
    const bool installed = std::filesystem::exists(modelHome() / name);
    const std::size_t words = model.labels.empty() ? 0 : catalog.labelSets().at(model.labels).count;
    if (json) {
      print({{"name", name},
             {"about", model.about},
             {"license", model.license},
             {"source", model.source},
             {"megabytes", model.megabytes},
             {"labels", words},
             {"checksums", catalog.checksums(model)},
             {"by_hand", model.needsHands()},
             {"installed", installed}});
    } else {
      fmt::print("{:<20} {:>7} {:>6}  {:<9} {:<9} {}\n{:<20} {}\n", name,
                 model.megabytes > 0 ? fmt::format("{:.0f}", model.megabytes) : "-",
                 words == 0 ? "yours" : std::to_string(words), catalog.checksums(model),
                 installed            ? "installed"
                 : model.needsHands() ? "by hand"
                                      : "",
                 model.license, "", model.about);
    }
  }
}

void get(const std::string& name, const FetchOptions& options, bool json) {
  const Catalog catalog = Catalog::load();
  const auto progress = makeStderrProgress();
  const std::vector<std::string> names = catalog.namesOf(name);
  Skipped failed("not fetched");
  for (const std::string& one : names) {
    if (names.size() > 1 && !options.replace && std::filesystem::exists(modelHome() / one)) continue;
    try {
      const FetchedModel model = fetchModel(catalog, one, options, *progress);
      for (const std::string& note : model.notes) spdlog::warn("{}", note);
      report(model.check, json);
    } catch (const Error& e) {
      if (names.size() == 1 || e.code() == ErrorCode::interrupted) throw;
      failed.add(fmt::format("{}: {}", one, e.what()));
    }
  }
  if (failed.count() > 0)
    fail(ErrorCode::network, "{} of the {} models of {} could not be fetched; run this again for the rest",
         failed.count(), names.size(), name);
}

std::string textOf(const std::vector<convert::OnnxSummary::Tensor>& tensors) {
  std::string text;
  for (const auto& [name, shape] : tensors)
    text += fmt::format("{}{} [{}]", text.empty() ? "" : ", ", name, fmt::join(shape, "×"));
  return text;
}

nlohmann::ordered_json jsonOf(const std::vector<convert::OnnxSummary::Tensor>& tensors) {
  nlohmann::ordered_json json;
  for (const auto& [name, shape] : tensors) json[name] = shape;
  return json;
}

void convertNetwork(const std::string& network, const std::string& output, bool overwrite, bool json) {
  const bool isFile = std::filesystem::is_regular_file(network);
  const auto source =
      isFile ? convert::NetworkSource{.file = network} : convert::networkOf(getModelFolder(network));
  const convert::OnnxSummary summary = convert::writeOnnx(source, output, overwrite);
  if (json)
    print({{"file", output},
           {"inputs", jsonOf(summary.inputs)},
           {"outputs", jsonOf(summary.outputs)},
           {"operator_set", summary.operatorSet},
           {"nodes", summary.nodes}});
  else
    fmt::print("{}: {} → {}, {} nodes of operator set {}\n", printable(output), textOf(summary.inputs),
               textOf(summary.outputs), summary.nodes, summary.operatorSet);
}

void quantize(const std::string& model, const Sequence& images, const convert::QuantizeOptions& options,
              bool json) {
  const auto progress = makeStderrProgress();
  const convert::QuantizedModel made =
      convert::quantizeModel(getModelFolder(model), images, options, *progress);
  Skipped skipped;
  for (const std::string& problem : made.problems) skipped.add(problem);
  if (json)
    print({{"file", made.file.string()},
           {"sha256", made.sha256},
           {"values", made.values},
           {"images", made.images},
           {"skipped", made.problems.size()}});
  else
    fmt::print("{}: {} of 8 bits, measured on {}; use it with --precision int8\n",
               printable(made.file.string()), report::counted(made.values, "value"),
               report::counted(made.images, "image"));
}

void addQuantizeCommand(CLI::App& models) {
  struct Arguments {
    explicit Arguments(CLI::App& command) : declared(command) {}
    std::string model;
    SequenceArguments images;
    convert::QuantizeOptions options;
    bool json = false;
    DeclaredOptions declared;
  };
  CLI::App* command = models.add_subcommand(
      "quantize",
      "Make a network of 8 bits of a model, by images of yours; large networks run 1.8 times as fast");
  auto arguments = std::make_shared<Arguments>(*command);
  command->add_option("MODEL", arguments->model, "A name of `models list`, or a folder with a model.toml")
      ->required();
  arguments->images.addTo(arguments->declared, true, false);
  arguments->declared.add(declare(arguments->options.calibration), {"images", "light"});
  command->add_option("--ranges", arguments->options.ranges, "A file for the table of measured ranges, too");
  command
      ->add_option("--threads", arguments->options.threads, "Threads of the network; 0 = one per free core")
      ->check(wholeNumber(0, 1024));
  addOverwriteOption(*command, arguments->options.overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia models quantize mobilenet-v2 ~/photos\n"
              "  estancia map SEQ -o FILE --model mobilenet-v2 --precision int8");
  command->callback([arguments] {
    quantize(arguments->model, *arguments->images.open(), arguments->options, arguments->json);
  });
}

}  // namespace

void addModelsCommand(CLI::App& app) {
  struct Arguments {
    Arguments(CLI::App& check, CLI::App& get) : checking(check), getting(get) {}
    ModelArguments model;
    std::string folder, output;
    bool overwrite = false, json = false;
    FetchOptions fetch;
    DeclaredOptions checking, getting;
  };
  CLI::App* command =
      app.add_subcommand("models", "List, fetch, add, check, convert and quantize the networks that label");
  command->require_subcommand(1);
  addExamples(*command,
              "  estancia models list\n"
              "  estancia models check inception-v3\n"
              "  estancia models add ~/places205\n"
              "  estancia models get places365-googlenet");

  CLI::App* check = command->add_subcommand("check", "Open a model, compare its digests, label test images");
  CLI::App* fetch = command->add_subcommand("get", "Download a model of the catalog, check and install it");
  auto arguments = std::make_shared<Arguments>(*check, *fetch);

  CLI::App* listing = command->add_subcommand("list", "List the models and engines at hand");
  addJsonOption(*listing, arguments->json);
  addExamples(*listing, "  estancia models list");
  listing->callback([arguments] { list(arguments->json); });

  check->add_option("MODEL", arguments->model.model, "A name of `models list`, or a folder with a model.toml")
      ->required();
  arguments->model.addLabelerTo(arguments->checking);
  addJsonOption(*check, arguments->json);
  addExamples(*check, "  estancia models check inception-v3");
  check->callback(
      [arguments] { report(checkModel(arguments->model.model, arguments->model.options), arguments->json); });

  CLI::App* add = command->add_subcommand(
      "add",
      "Check a model folder, convert its network to ONNX where needed, and copy it to the other models");
  add->add_option("FOLDER", arguments->folder, "The folder with model.toml, network and label file")
      ->required();
  addOverwriteOption(*add, arguments->overwrite);
  addJsonOption(*add, arguments->json);
  addExamples(*add, "  estancia models add ~/places205");
  add->callback([arguments] {
    const convert::ConvertedModel model(arguments->folder);
    report(addModel(model.folder(), arguments->overwrite), arguments->json);
  });

  CLI::App* conversion =
      command->add_subcommand("convert", "Write a network as an ONNX file that any engine can open");
  conversion
      ->add_option("NETWORK", arguments->folder,
                   "A .tflite, .lite, .json (TensorFlow.js) or .onnx file, or a name of `models list`")
      ->required();
  addOutputOption(*conversion, arguments->output, "The file to write, NAME.onnx")->required();
  addOverwriteOption(*conversion, arguments->overwrite);
  addJsonOption(*conversion, arguments->json);
  addExamples(*conversion, "  estancia models convert mobilenet.tflite -o mobilenet.onnx");
  conversion->callback([arguments] {
    convertNetwork(arguments->folder, arguments->output, arguments->overwrite, arguments->json);
  });

  addQuantizeCommand(*command);

  CLI::App* catalog = command->add_subcommand("catalog", "List the models that `get` can fetch");
  addJsonOption(*catalog, arguments->json);
  addExamples(*catalog, "  estancia models catalog");
  catalog->callback([arguments] { showCatalog(arguments->json); });

  fetch
      ->add_option("NAME", arguments->folder,
                   "A name of `models catalog`, or thesis: the seven networks of its Table 1.2")
      ->required();
  arguments->getting.add(declare(arguments->fetch), {"replace=overwrite", "refetch=restart"});
  addJsonOption(*fetch, arguments->json);
  addExamples(*fetch,
              "  estancia models get mobilenet-v2\n"
              "  estancia models get imagenet-alexnet --overwrite\n"
              "  estancia models get thesis");
  fetch->callback([arguments] { get(arguments->folder, arguments->fetch, arguments->json); });
}

}  // namespace estancia::apps
