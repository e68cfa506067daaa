// estancia localize: where in a map are these images?
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "estancia/query/map_json.hpp"
#include "localization.hpp"

namespace estancia::apps {
namespace {

struct LocalizeArguments {
  explicit LocalizeArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  LocalizationArguments localization;
  DeclaredOptions declared;
  bool json = false;
};

void printAnswer(const TopologicalMap& map, const std::string& image, const Localization& at, bool json) {
  if (json) return print(toJson(image, at, map));
  fmt::print(
      "{}: place {} ({:.0f} %){}, at {}{}; alone: place {}, nearest {} at {:.3f}\n", image, at.beliefNode,
      100 * at.confidence,
      at.beliefZone.value_or(-1) >= 0
          ? fmt::format(", zone {} ({:.0f} %)", *at.beliefZone, 100 * at.zoneConfidence)
          : "",
      map.frames[at.beliefImage].name,
      at.unmapped > 0.5 ? fmt::format(" (a view that is not in the map, {:.0f} %)", 100 * *at.unmapped) : "",
      at.node, map.frames[at.nearestImage].name, at.distance);
}

void run(const LocalizeArguments& arguments) {
  Localizer localizer(arguments.localization.map, arguments.localization.localizer);
  localize(arguments.localization, localizer, arguments.sequence, nameBesideResults("localizing"),
           [&](std::size_t, const Frame& frame, const Localization& answer) {
             printAnswer(localizer.map(), frame.name, answer, arguments.json);
           });
}

}  // namespace

void addLocalizeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("localize", "Find where in a map a sequence of images was taken");
  auto arguments = std::make_shared<LocalizeArguments>(*command);
  arguments->localization.addTo(arguments->declared);
  arguments->sequence.addTo(arguments->declared);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia localize home.estancia ~/today\n"
              "  estancia localize home.estancia ~/today --json | jq .belief_node");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
