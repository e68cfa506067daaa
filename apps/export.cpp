// estancia export: the map for other programs.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common.hpp"
#include "estancia/topology/export.hpp"
#include "estancia/topology/store.hpp"

namespace estancia::apps {

void addExportCommand(CLI::App& app) {
  struct Arguments {
    std::string map, format, output;
    ExportOptions options;
    bool oneWay = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", "Write the map for another program");
  command->add_option("MAP", arguments->map, "The map file")->required();
  std::string formats = "What to write:";
  std::vector<std::string> names;
  for (const auto& [name, explanation] : exportFormats()) {
    formats += fmt::format("\n{} ({})", name, explanation);
    names.push_back(name);
  }
  command->add_option("--format", arguments->format, formats)->required()->check(CLI::IsMember(names));
  command->add_option("-o,--output", arguments->output, "File to write; default: stdout");
  command->add_option("--words", arguments->options.words, "How many of a place's best labels go along")
      ->capture_default_str();
  command->add_option("--frame", arguments->options.frame, "nav2: name of the poses' coordinate frame")
      ->capture_default_str();
  command->add_flag("--one-way", arguments->oneWay, "nav2: edges only in the direction they were driven");
  addExamples(*command,
              "  estancia export home.estancia --format json | jq '.places[0].words'\n"
              "  estancia export home.estancia --format nav2 -o home.geojson");
  command->callback([arguments] {
    arguments->options.bothWays = !arguments->oneWay;
    const TopologicalMap map = MapStore::open(arguments->map, MapStore::Access::read).load();
    if (arguments->output.empty()) {
      fmt::print("{}", exportMap(map, arguments->format, arguments->options));
    } else {
      exportMap(map, arguments->format, arguments->output, arguments->options);
      spdlog::info("wrote {}", arguments->output);
    }
  });
}

}  // namespace estancia::apps
