// estancia objects predict: the classes of the objects in a sequence, by image and by shape.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/annotated_image.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/objects/predict_sequence.hpp"
#include "labeling.hpp"
#include "objects.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

using report::counted;

struct ObjectsPredictArguments {
  explicit ObjectsPredictArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  std::string objectModel, image;
  ModelArguments model;
  PredictSequenceOptions options;
  bool shapeOnly = false, overwrite = false, json = false;
  DeclaredOptions declared;
};

class PredictionPrinter {
 public:
  PredictionPrinter(const TargetClasses& targets, bool json) : classes_(targets.names()), json_(json) {}

  void add(const PredictedFrame& frame) {
    for (const PredictedObject& object : frame.objects) {
      last_[object.instance] = object;
      if (!object.problem.empty())
        spdlog::warn("{}, object {}: {}", frame.name, object.instance, object.problem);
    }
    if (json_)
      print(toJson(frame, classes_));
    else
      printText(frame);
  }

  /// The last answer for each object.
  void printSummary() const {
    if (json_) return;
    const auto unknown =
        std::ranges::count_if(last_, [](const auto& entry) { return entry.second.answer.classIndex < 0; });
    fmt::print("\n{}, {} of them of none of the classes\n", counted(last_.size(), "object"), unknown);
    for (const auto& [number, object] : last_)
      if (object.answer.classIndex >= 0)
        fmt::print("  {:>4}  {:<10} {:<20} {}\n", number, counted(object.views, "view"),
                   textOf(object.answer), object.answer.why);
  }

  std::size_t count() const { return last_.size(); }

 private:
  std::string textOf(const FusedAnswer& answer) const {
    if (answer.classIndex < 0) return "?";
    return fmt::format("{} {:.0f} %", classes_[static_cast<std::size_t>(answer.classIndex)],
                       100 * answer.probability);
  }

  std::string textOf(const std::vector<float>& probabilities) const {
    if (probabilities.empty()) return "-";
    const auto best = std::ranges::max_element(probabilities);
    return fmt::format("{} {:.0f} %", classes_[static_cast<std::size_t>(best - probabilities.begin())],
                       100 * *best);
  }

  void printText(const PredictedFrame& frame) const {
    fmt::print("{}: {}\n", frame.name, counted(frame.objects.size(), "object"));
    for (std::size_t i = 0; i < frame.objects.size(); ++i) {
      const PredictedObject& object = frame.objects[i];
      const Cluster& cluster = frame.frame.clusters.clusters[i];
      fmt::print("  {:>4} at {:.2f} m  image {:<18} shape {:<18} -> {:<18} {}{}\n", object.instance,
                 cluster.center.z, textOf(object.image), textOf(object.shape), textOf(object.answer),
                 object.answer.why, cluster.atBorder ? "; cut by the border" : "");
    }
  }

  std::vector<std::string> classes_;
  bool json_;
  std::map<std::size_t, PredictedObject> last_;
};

void run(const ObjectsPredictArguments& a) {
  requireImage(a.image, a.overwrite, {a.objectModel, a.sequence.path});
  const ObjectModel model = readObjectModel(a.objectModel);
  const auto sequence = a.sequence.open();
  const auto labeler = a.shapeOnly ? nullptr : a.model.open();
  ObjectPredictor predictor(model, labeler.get(), a.options.objects);
  if (labeler != nullptr && !model.prior().empty() && !predictor.correctsPrior())
    spdlog::warn(
        "{} did not label the training data, {} did; the probabilities are not corrected by the prior",
        labeler->identity(), model.labeler());

  PredictionPrinter printer(model.targets(), a.json);
  cv::Mat drawn;
  Skipped skipped;
  const std::size_t frames = predictSequence(
      *sequence, predictor, a.options,
      [&](const PredictedFrame& frame) {
        printer.add(frame);
        if (!a.image.empty())
          drawn = report::drawObjects(frame.frame.image, frame.objects, model.targets().names());
      },
      [&](const std::string& problem) { skipped.add(problem); });
  if (!drawn.empty()) writePng(drawn, a.image);
  printer.printSummary();
  if (interrupted()) throw Interrupted(fmt::format("stopped after {}", counted(frames, "frame")));
  if (printer.count() == 0) throw NoAnswer{};
}

}  // namespace

void addObjectsPredict(CLI::App& objects) {
  CLI::App* command =
      objects.add_subcommand("predict", "Classify the objects in a sequence by image, by shape, and by both");
  auto a = std::make_shared<ObjectsPredictArguments>(*command);
  a->sequence.addTo(a->declared);
  SequenceArguments::addDepthTo(a->declared);
  command->add_option("--object-model", a->objectModel, "The shape classifier, of `estancia objects train`")
      ->type_name("FILE")
      ->required();
  command
      ->add_option(
          "--model", a->model.model,
          fmt::format("The model that labels the images: a name of `models list`, a folder, or several "
                      "joined by +\nDefault: {}",
                      a->model.byDefault))
      ->type_name("NAME");
  a->model.addLabelerTo(a->declared);
  auto* shapeOnly = command->add_flag("--shape-only", a->shapeOnly, "Use no labeler, only the shapes");
  a->declared.add(declare(a->options), {"first", "every", "max-frames", "strict"});
  a->declared.add(declare(a->options.objects.clusters), {"min-points=min-pixels"});
  a->declared.add(declare(a->options.objects.crops), {"margin", "background"});
  for (const char* other : {"--model", "--engine", "--margin", "--background"})
    shapeOnly->excludes(command->get_option(other));
  command->add_option("--render", a->image, "Draw the last frame with its objects (PNG)");
  addOverwriteOption(*command, a->overwrite);
  addJsonOption(*command, a->json);
  addExamples(
      *command,
      "  estancia objects predict ~/kitchen --object-model kitchen.objects\n"
      "  estancia objects predict ~/kitchen-at-night --object-model kitchen.objects --shape-only --json\n"
      "  estancia objects predict ~/kitchen --object-model kitchen.objects --first 100 --max-frames 1 "
      "--render found.png");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
