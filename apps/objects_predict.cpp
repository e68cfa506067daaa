// estancia objects predict: what the things in a sequence are, by image and by shape.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <limits>
#include <map>
#include <optional>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/image_writer.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/report/object_image.hpp"
#include "estancia/report/text.hpp"
#include "labeling.hpp"
#include "objects.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct Arguments {
  SequenceArguments sequence;
  std::string model, image;
  ModelArguments labeler;
  CropOptions patches;
  bool shapeOnly = false, overwrite = false, json = false;
  std::size_t first = 0, every = 1, frames = 0, least = ClusterOptions().least;
};

std::string_view nameOf(FusedAnswer::Source source) {
  switch (source) {
    case FusedAnswer::Source::none:
      return "none";
    case FusedAnswer::Source::image:
      return "image";
    case FusedAnswer::Source::shape:
      return "shape";
    case FusedAnswer::Source::both:
      return "both";
  }
  return "none";
}

/// The likeliest word; nothing where nothing is said.
std::optional<std::size_t> likeliest(const std::vector<float>& said) {
  if (said.empty()) return std::nullopt;
  return std::max_element(said.begin(), said.end()) - said.begin();
}

class PredictionPrinter {
 public:
  PredictionPrinter(const TargetClasses& study, bool json) : names_(study.names()), json_(json) {}

  void frame(const ClusteredFrame& frame, const std::string& name,
             const std::vector<PredictedObject>& objects, double clustering, const PredictSeconds& seconds) {
    for (const PredictedObject& object : objects) {
      last_[object.instance] = object;
      if (!object.problem.empty()) spdlog::warn("{}, thing {}: {}", name, object.instance, object.problem);
    }
    if (json_)
      asJson(frame, name, objects, clustering, seconds);
    else
      asText(frame, name, objects);
  }

  /// What was believed of each thing at last.
  void things() const {
    if (json_) return;
    std::size_t unknown = 0;
    for (const auto& [number, object] : last_) unknown += object.answer.classIndex < 0 ? 1 : 0;
    fmt::print("\n{}, {} believed to be none of the words\n", counted(last_.size(), "thing"), unknown);
    for (const auto& [number, object] : last_)
      if (object.answer.classIndex >= 0)
        fmt::print("  {:>4}  {:<10} {:<20} {}\n", number, counted(object.views, "view"),
                   believed(object.answer), object.answer.why);
  }

  std::size_t count() const { return last_.size(); }

 private:
  std::string believed(const FusedAnswer& belief) const {
    if (belief.classIndex < 0) return "?";
    return fmt::format("{} {:.0f} %", names_[static_cast<std::size_t>(belief.classIndex)],
                       100 * belief.probability);
  }

  std::string said(const std::vector<float>& of) const {
    const auto best = likeliest(of);
    return best ? fmt::format("{} {:.0f} %", names_[*best], 100 * of[*best]) : "-";
  }

  void asText(const ClusteredFrame& frame, const std::string& name,
              const std::vector<PredictedObject>& objects) const {
    fmt::print("{}: {}\n", name, counted(objects.size(), "thing"));
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const PredictedObject& object = objects[i];
      const Cluster& cluster = frame.clusters.clusters[i];
      fmt::print("  {:>4} at {:.2f} m  image {:<18} shape {:<18} -> {:<18} {}{}\n", object.instance,
                 cluster.center.z, said(object.image), said(object.shape), believed(object.answer),
                 object.answer.why, cluster.atBorder ? "; cut by the border" : "");
    }
  }

  Json answer(const std::vector<float>& of) const {
    const auto best = likeliest(of);
    if (!best) return nullptr;
    Json words;
    for (std::size_t w = 0; w < names_.size(); ++w) words[names_[w]] = of[w];
    return {{"word", names_[*best]}, {"probability", of[*best]}, {"words", words}};
  }

  void asJson(const ClusteredFrame& frame, const std::string& name,
              const std::vector<PredictedObject>& objects, double clustering,
              const PredictSeconds& seconds) const {
    Json things = Json::array();
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const PredictedObject& object = objects[i];
      const Cluster& cluster = frame.clusters.clusters[i];
      Json thing{{"thing", object.instance},
                 {"views", object.views},
                 {"box", {object.box.x, object.box.y, object.box.width, object.box.height}},
                 {"center", {cluster.center.x, cluster.center.y, cluster.center.z}},
                 {"flat", cluster.flat},
                 {"at_border", cluster.atBorder},
                 {"image", answer(object.image)},
                 {"coverage", object.coverage},
                 {"shape", answer(object.shape)}};
      const FusedAnswer& belief = object.answer;
      thing["believed"] = {
          {"word",
           belief.classIndex < 0 ? Json() : Json(names_[static_cast<std::size_t>(belief.classIndex)])},
          {"probability", belief.probability},
          {"source", nameOf(belief.source)},
          {"why", belief.why}};
      if (!object.problem.empty()) thing["problem"] = object.problem;
      things.push_back(thing);
    }
    print({{"frame", name},
           {"things", things},
           {"seconds",
            {{"clusters", clustering},
             {"images", seconds.crops},
             {"labeler", seconds.labeler},
             {"shapes", seconds.shapes},
             {"classifier", seconds.classifier}}}});
  }

  std::vector<std::string> names_;
  bool json_;
  std::map<std::size_t, PredictedObject> last_;
};

void run(const Arguments& a) {
  requireImage(a.image, a.overwrite, {a.model, a.sequence.path});
  const ObjectModel model = readObjectModel(a.model);
  const auto sequence = a.sequence.open();
  requireClusterable(*sequence);
  if (a.first >= sequence->size())
    throw Error(fmt::format("{} has {}; --first {} is behind the last", sequence->name(),
                            counted(sequence->size(), "frame"), a.first));
  const auto labeler = a.shapeOnly ? nullptr : a.labeler.open();
  PredictOptions options;
  options.crops = a.patches;
  options.threads = a.labeler.options.threads;
  ClusterOptions clustering;
  clustering.least = a.least;
  clustering.threads = options.threads;
  ObjectPredictor predictor(model, labeler.get(), options);
  if (labeler != nullptr && !model.prior().empty() && !predictor.correctsPrior())
    spdlog::warn("{} is not who named what was learned from ({}), so its answers are taken as they are",
                 labeler->identity(), model.labeler());

  PredictionPrinter telling(model.targets(), a.json);
  std::size_t read = 0;
  cv::Mat drawn;
  for (std::size_t i = a.first; i < sequence->size() && (a.frames == 0 || read < a.frames);
       i += std::min(a.every, sequence->size())) {
    if (interrupted()) break;
    const Frame& about = sequence->frame(i);
    ImageAndDepth frame;
    try {
      frame = readImageAndDepth(*sequence, i);
    } catch (const Error& error) {
      if (a.sequence.strict) throw;
      spdlog::warn("skipped: {}: {}", about.name, error.what());
      continue;
    }
    const auto begin = std::chrono::steady_clock::now();
    const ClusteredFrame clustered =
        clusteredFrame(frame.image, frame.depth, *sequence->intrinsics(), clustering);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    PredictSeconds seconds;
    std::vector<PredictedObject> objects;
    try {
      objects = predictor.predict(clustered, about.pose, &seconds);
    } catch (const Interrupted&) {
      break;
    }
    ++read;
    telling.frame(clustered, about.name, objects, took.count(), seconds);
    if (!a.image.empty()) drawn = report::drawObjects(clustered.image, objects, model.targets().names());
  }
  if (read == 0 && !interrupted())
    throw Error(fmt::format("{}: no frame can be read with its depth", sequence->name()));
  if (!drawn.empty()) writePng(a.image, drawn);
  telling.things();
  if (interrupted()) throw Interrupted(fmt::format("stopped after {}", counted(read, "frame")));
  if (telling.count() == 0) throw NoAnswer{};
}

}  // namespace

void addObjectsPredict(CLI::App& objects) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = objects.add_subcommand(
      "predict", "Tell what the things in a sequence are: by image, by shape, and which to believe");
  addSequenceWithDepth(*command, a->sequence);
  command->add_option("--model", a->model, "What was learned, of `estancia objects train`")->required();
  command->add_option(
      "--labeler", a->labeler.model,
      fmt::format("What labels the images, as --model of `estancia objects label`; default: {}",
                  a->labeler.byDefault));
  addPatchOptions(*command, a->patches);
  a->labeler.addOptionsTo(*command);
  auto* shapeOnly = command->add_flag("--shape-only", a->shapeOnly, "Ask no labeler: go by the shapes alone");
  for (const char* other : {"--labeler", "--engine", "--margin", "--background"}) shapeOnly->excludes(other);
  command->add_option("--first", a->first, "The frame to begin with, from 0")->check(CLI::NonNegativeNumber);
  command->add_option("--every", a->every, "Look at every so-many-th frame only")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--frames", a->frames, "Look at so many frames; default: all")->check(positive());
  command
      ->add_option("--least", a->least, "Pixels of a thing at least, in an image with a focal length of 525")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--picture", a->image, "Draw the last frame with its things (PNG)");
  command->add_flag("--overwrite", a->overwrite, "Replace an existing image");
  addJsonOption(*command, a->json);
  addExamples(*command,
              "  estancia objects predict ~/kitchen --model kitchen.objects\n"
              "  estancia objects predict ~/kitchen-at-night --model kitchen.objects --shape-only --json\n"
              "  estancia objects predict ~/kitchen --model kitchen.objects --first 100 --frames 1 --picture "
              "found.png");
  command->callback([a] { run(*a); });
}

}  // namespace estancia::apps
