// estancia export: a map or zones for other programs.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/topology/export.hpp"
#include "estancia/zones/zone_file.hpp"
#include "estancia/zones/zones_json.hpp"

namespace estancia::apps {
namespace {

constexpr const char* zoneFormat = "rooms";

std::string textOf(const std::string& file, const std::string& format, const ExportOptions& options) {
  const bool zones = isZoneFile(file);
  if (zones != (format == zoneFormat))
    throw Error(zones
                    ? fmt::format("{} holds zones, which are written as {}", file, zoneFormat)
                    : fmt::format("{} is no file of zones, whose rooms could be written; make one: estancia "
                                  "zones {} -o FILE",
                                  file, file));
  if (zones) return toRoomsJson(readZones(file), options.words);
  return exportMap(readMap(file), format, options);
}

}  // namespace

void addExportCommand(CLI::App& app) {
  struct Arguments {
    std::string map, format, output;
    ExportOptions options;
    bool oneWay = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", "Write a map or zones for another program");
  command->add_option("MAP", arguments->map, "The map file, or a file of zones")->required();
  std::string formats = "What to write:";
  std::vector<std::string> names;
  for (const auto& [name, explanation] : exportFormats()) {
    formats += fmt::format("\n{} ({})", name, explanation);
    names.push_back(name);
  }
  formats += fmt::format("\n{} (of a file of zones: rooms and their words, as simple JSON)", zoneFormat);
  names.emplace_back(zoneFormat);
  command->add_option("--format", arguments->format, formats)->required()->check(CLI::IsMember(names));
  command->add_option("-o,--output", arguments->output, "File to write; default: stdout");
  command
      ->add_option("--words", arguments->options.words,
                   "How many of the best labels of a place or room go along")
      ->capture_default_str();
  command->add_option("--frame", arguments->options.frame, "nav2: name of the poses' coordinate frame")
      ->capture_default_str();
  command->add_flag("--one-way", arguments->oneWay, "nav2: edges only in the direction they were driven");
  addExamples(*command,
              "  estancia export home.estancia --format json | jq '.places[0].words'\n"
              "  estancia export home.estancia --format nav2 -o home.geojson\n"
              "  estancia export home.zones --format rooms | jq .kitchen.words");
  command->callback([arguments] {
    arguments->options.bidirectional = !arguments->oneWay;
    const std::string text = textOf(arguments->map, arguments->format, arguments->options);
    if (arguments->output.empty()) {
      fmt::print("{}", text);
    } else {
      requireNoData(arguments->output, {arguments->map});
      writeWhole(arguments->output, text);
      spdlog::info("wrote {}", arguments->output);
    }
  });
}

}  // namespace estancia::apps
