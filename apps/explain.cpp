// estancia explain: why did a frame go where it went?
#include <fmt/format.h>

#include <cmath>

#include "common.hpp"
#include "estancia/topology/explain.hpp"
#include "estancia/topology/store.hpp"

namespace estancia::apps {
namespace {

nlohmann::json numberOrNull(double value) {
  return std::isnan(value) ? nlohmann::json(nullptr) : nlohmann::json(value);
}

}  // namespace

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
    const TopologicalMap map = MapStore::open(arguments->map, MapStore::Access::read).load();
    const std::size_t frame = getFrame(map, arguments->frame);
    const std::vector<std::string> sentences = explain(map, frame);
    if (!arguments->json) {
      for (const std::string& sentence : sentences) fmt::print("{}\n", sentence);
      return;
    }
    const Decision& decision = map.decisions.at(frame);
    print({{"frame", map.frames[frame].name},
           {"number", frame},
           {"decision", toString(decision.kind)},
           {"node", decision.node},
           {"node_now", map.frames[frame].node},
           {"current", decision.current},
           {"to_current", numberOrNull(decision.toCurrent)},
           {"other", decision.other},
           {"to_other", numberOrNull(decision.toOther)},
           {"tau_join", decision.tauJoin},
           {"tau_revisit", decision.tauRevisit},
           {"sentences", sentences}});
  });
}

}  // namespace estancia::apps
