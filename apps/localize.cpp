// estancia localize: where in a map are these images?
#include <fmt/format.h>

#include <deque>

#include "common.hpp"
#include "estancia/label/model.hpp"
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/session.hpp"

namespace estancia::apps {
namespace {

struct Arguments {
  SequenceArguments sequence;
  std::string map, model;
  LocalizerOptions localizer;
  bool json = false;
};

void printAnswer(const TopologicalMap& map, const std::string& image, const Localization& at, bool json) {
  const std::string& nearest = map.frames[at.nearestImage].name;
  const std::string& believed = map.frames[at.beliefImage].name;
  if (json) {
    print({{"image", image},
           {"node", at.node},
           {"nearest_image", nearest},
           {"distance", at.distance},
           {"belief_node", at.beliefNode},
           {"belief_image", believed},
           {"confidence", at.confidence}});
  } else {
    fmt::print("{}: place {} ({:.0f} %), at {}; alone: place {}, nearest {} at {:.3f}\n", image,
               at.beliefNode, 100 * at.confidence, believed, at.node, nearest, at.distance);
  }
}

void run(const Arguments& arguments) {
  const MapReader reader(arguments.map);
  const TopologicalMap& map = reader.map();
  const auto sequence = arguments.sequence.open();
  const auto labeler = loadModel(arguments.model.empty() ? defaultModel : arguments.model);
  requireSameVocabulary(map.vocabulary, labeler->vocabulary(), arguments.map);
  std::size_t stride = 1;
  DescriptorMatrix images = reader.descriptors(arguments.localizer.mostImages, stride);
  Localizer localizer({&map, &reader.mapper().bank(), std::move(images), stride}, arguments.localizer);

  std::deque<std::string> waiting;
  const auto answer = [&](const std::vector<Localization>& answers) {
    for (const Localization& at : answers) {
      printAnswer(map, waiting.front(), at, arguments.json);
      waiting.pop_front();
    }
  };
  forEachLabelled(*sequence, *labeler, 0, arguments.sequence.strict, "localizing",
                  [&](const LabelledFrame& frame) {
                    waiting.push_back(sequence->frame(frame.index).name);
                    answer(localizer.add(frame.descriptor));
                  });
  answer(localizer.finish());
}

}  // namespace

void addLocalizeCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("localize", "Find where in a map a sequence of images was taken");
  command->add_option("MAP", arguments->map, "The map file")->required();
  arguments->sequence.addTo(*command);
  command->add_option("--model", arguments->model,
                      "The model that the map was made with; default: inception-v3");
  command
      ->add_option("--lookahead", arguments->localizer.lookahead,
                   "Answer this many frames late, and better (smoothing); 0 answers at once")
      ->capture_default_str();
  command
      ->add_option("--most-images", arguments->localizer.mostImages,
                   "Compare with at most so many stored images, evenly thinned")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia localize home.estancia ~/today\n"
              "  estancia localize home.estancia ~/today --json | jq .belief_node");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
