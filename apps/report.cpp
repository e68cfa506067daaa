// estancia report: the map as a page.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/topology/quality.hpp"
#include "estancia/topology/store.hpp"

namespace estancia::apps {
namespace {

struct Arguments {
  std::string map, output, title, label, floorPlan;
  std::array<double, 4> extent{};
};

void run(const Arguments& arguments, const CLI::App& command) {
  const MapStore store = MapStore::open(arguments.map, MapStore::Access::read);
  const TopologicalMap map = store.load();
  MapPage page{map};
  page.title =
      arguments.title.empty() ? std::filesystem::path(arguments.map).stem().string() : arguments.title;
  page.measures = measuresOf(evaluate(map));
  if (!arguments.label.empty()) {
    const auto labels = findLabels(map.vocabulary, arguments.label);
    if (labels.empty())
      throw Error(fmt::format("no label of the map means \"{}\"; try estancia ask {} \"{}\"", arguments.label,
                              arguments.map, arguments.label));
    page.label = labels.front();
  }
  if (!arguments.floorPlan.empty()) {
    if (command.count("--extent") == 0)
      throw Error(
          "--floor-plan needs --extent XMIN YMIN XMAX YMAX: where the picture's edges are in the map [m]");
    page.floorPlan = readFloorPlan(arguments.floorPlan, arguments.extent);
  }
  page.pictures.frames = store.pictureFrames();
  page.pictures.read = [&store](std::size_t frame) { return store.picture(frame); };
  writeMapPage(arguments.output, page);
  spdlog::info("wrote {}", arguments.output);
}

}  // namespace

void addReportCommand(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("report", "Write a page that shows the map: one HTML file, no network");
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("-o,--output", arguments->output, "The HTML file to write")->required();
  command->add_option("--title", arguments->title, "Title of the page; default: the map's name");
  command->add_option("--label", arguments->label, "Start as the heat map of this label");
  command->add_option("--floor-plan", arguments->floorPlan, "A picture of the building to draw the map on")
      ->check(CLI::ExistingFile);
  command->add_option("--extent", arguments->extent,
                      "The floor plan's edges in the map [m]: XMIN YMIN XMAX YMAX");
  addExamples(*command,
              "  estancia report home.estancia -o home.html\n"
              "  estancia report home.estancia -o home.html --label refrigerator");
  command->callback([arguments, command] { run(*arguments, *command); });
}

}  // namespace estancia::apps
