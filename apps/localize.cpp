// estancia localize: where in a map are these images?
#include <fmt/format.h>

#include "localization.hpp"

namespace estancia::apps {
namespace {

struct Arguments {
  SequenceArguments sequence;
  LocalizationArguments localization;
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
  const MapReader reader(arguments.localization.map);
  localize(arguments.localization, reader, arguments.sequence,
           [&](std::size_t, const Frame& frame, const Localization& answer) {
             printAnswer(reader.map(), frame.name, answer, arguments.json);
           });
}

}  // namespace

void addLocalizeCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("localize", "Find where in a map a sequence of images was taken");
  arguments->localization.addTo(*command);
  arguments->sequence.addTo(*command);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia localize home.estancia ~/today\n"
              "  estancia localize home.estancia ~/today --json | jq .belief_node");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
