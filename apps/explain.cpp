// estancia explain: why did a frame go where it went?
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/query/map_json.hpp"

namespace estancia::apps {
void addExplainCommand(CLI::App& app) {
  struct Arguments {
    std::string map, frame;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("explain", "Tell why the map put a frame where it is");
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("FRAME", arguments->frame, "The name of a frame, or its number in the map")->required();
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia explain home.estancia 120\n"
              "  estancia explain home.estancia kitchen_0042.jpg --json");
  command->callback([arguments] {
    const TopologicalMap map = readMap(arguments->map);
    const std::size_t frame = getFrame(map, arguments->frame);
    if (arguments->json) return print(explanationJson(map, frame));
    for (const std::string& sentence : explain(map, frame)) fmt::print("{}\n", sentence);
  });
}

}  // namespace estancia::apps
