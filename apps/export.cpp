// estancia export: a map or zones for other programs.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/world_query/export_world.hpp"
#include "estancia/zones/naming.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::apps {
namespace {

constexpr const char* zoneFormat = "rooms";

struct ExportArguments {
  explicit ExportArguments(CLI::App& command) : declared(command) {}
  std::string map, format, output;
  ExportOptions options;
  DeclaredOptions declared;
  bool overwrite = false, json = false;
};

std::string textOf(const std::string& file, const std::string& format, const ExportOptions& options) {
  if (!isZoneFile(file)) {
    WorldMap world = readWorld(file, maxFramesOfAnswers);
    if (world.places.isThinned() && listsFrames(format)) world.places.visits = readVisits(file);
    return exportWorld(world, format, options);
  }
  if (format != zoneFormat)
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("{} holds zones, which are written as {}", file, zoneFormat));
  return toRoomsJson(readZones(file), options.maxWords);
}

void run(const ExportArguments& arguments, const CLI::App& command) {
  for (const char* flag : {"--frame", "--one-way"})
    if (command.count(flag) > 0 && arguments.format != "nav2")
      throw Error(ErrorCode::invalidOption,
                  fmt::format("{} goes with --format nav2, not {}", flag, arguments.format));
  if (arguments.output.empty() && arguments.json)
    throw Error(ErrorCode::invalidOption, "--json describes the file that is written; give it by -o");
  if (!arguments.output.empty()) {
    requireNoData(arguments.output, {arguments.map});
    requireReplaceable(arguments.output, arguments.overwrite, io::isTextFile, "text file");
  }
  const std::string text = textOf(arguments.map, arguments.format, arguments.options);
  if (arguments.output.empty()) {
    fmt::print("{}", text);
    return;
  }
  writeWhole(arguments.output, text);
  if (arguments.json)
    print({{"file", arguments.output}, {"format", arguments.format}, {"bytes", text.size()}});
  else
    spdlog::info("wrote {}", arguments.output);
}

}  // namespace

void addExportCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("export", "Write a map or zones for another program");
  auto arguments = std::make_shared<ExportArguments>(*command);
  command->add_option("MAP", arguments->map, "The map file, or a file of zones")->required();
  std::string formats = "What to write:";
  std::vector<std::string> names;
  for (const auto& [name, explanation] : worldFormats()) {
    formats += fmt::format("\n  {}: {}", name, explanation);
    names.push_back(name);
  }
  formats += fmt::format("\nA file of zones is written as {} only, with their words", zoneFormat);
  command->add_option("--format", arguments->format, formats)->required()->check(CLI::IsMember(names));
  addOutputOption(*command, arguments->output, "File to write; default: stdout");
  arguments->declared.add(declare(arguments->options), {"max-words", "frame", "bidirectional=one-way"});
  addOverwriteOption(*command, arguments->overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia export home.estancia --format json | jq '.places[0].words'\n"
              "  estancia export home.estancia --format nav2 -o home.geojson\n"
              "  estancia export home.estancia --format rooms | jq '.rooms[] | {name, objects: "
              "[.places[].objects[].name]}'\n"
              "  estancia export home.estancia --format spark-dsg -o home.json\n"
              "  estancia export home.zones --format rooms | jq .kitchen.words");
  command->callback([arguments, command] { run(*arguments, *command); });
}

}  // namespace estancia::apps
