// estancia report: the map as a page.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/findings/label_findings.hpp"
#include "estancia/findings/object_sheet.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/readers/object_samples.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/report/zones_page.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_choice.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/world_file/world_store.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::apps {
namespace {

struct ReportArguments {
  explicit ReportArguments(CLI::App& command) : declared(command) {}
  std::string file, output, title, label, floorPlan, zones, map;
  std::array<double, 4> extent{};
  std::optional<int> from;
  NamingOptions naming;
  DeclaredOptions declared;
  bool overwrite = false, json = false;
};

std::string titleOf(const ReportArguments& arguments) {
  return arguments.title.empty() ? std::filesystem::path(arguments.file).stem().string() : arguments.title;
}

/// An image, or what ends with .json or is a folder: the rooms of a home.
FloorPlan floorPlanOf(const ReportArguments& arguments, const CLI::App& command) {
  const std::filesystem::path path = arguments.floorPlan;
  const bool home = path.extension() == ".json" || std::filesystem::is_directory(path);
  if (home != (command.count("--extent") == 0))
    throw Error(
        ErrorCode::invalidOption,
        home ? "--extent says where the edges of an image are; home.json has coordinates of its own: leave "
               "--extent out"
             : "--floor-plan needs --extent XMIN YMIN XMAX YMAX: where the image's edges are in the map [m]");
  return home ? readHomeFloorPlan(path) : readFloorPlan(path, arguments.extent);
}

/// What --label means.
std::size_t labelOf(const ReportArguments& arguments, const Vocabulary& vocabulary) {
  const LabelMatches found = chooseLabels(vocabulary, arguments.label, installedWordGraph);
  if (found.labels.empty())
    throw Error(ErrorCode::unknownName,
                fmt::format("no label of the map means \"{}\"; try estancia ask {} \"{}\"{}",
                            printable(arguments.label), printable(arguments.file), printable(arguments.label),
                            missingWordsHint(installedWordGraph)));
  const LabelMatch& best = found.labels.front();
  if (!best.reason.empty() || !found.corrected.empty())
    spdlog::info("no label is called \"{}\": the page starts as the heat map of {}",
                 printable(arguments.label), describeMatches(vocabulary, {&best, 1}).front());
  return best.label;
}

void writeMap(const ReportArguments& arguments, const CLI::App& command) {
  if (!arguments.map.empty())
    throw Error(ErrorCode::invalidOption,
                fmt::format("--map gives images to zones; {} is a map and has its own", arguments.file));
  MapStore store = MapStore::open(arguments.file, MapStore::Access::read);
  store.beginReading();
  WorldMap world{store.load()};
  const WorldStore layers(store, MapStore::Access::read);
  layers.read(world);
  const TopologicalMap& map = world.places;
  if (arguments.from && world.objects.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("--from is where ways to objects start, and {} has no objects; leave it out",
                            arguments.file));
  const WorldPage above{.world = world,
                        .image = [&layers](int object) { return layers.objectImage(object); },
                        .from = arguments.from};
  MapPage page{map};
  page.world = &above;
  page.title = titleOf(arguments);
  page.measures = measuresOf(evaluate(map));
  if (!arguments.label.empty()) page.label = labelOf(arguments, map.vocabulary);
  if (!arguments.floorPlan.empty()) page.floorPlan = floorPlanOf(arguments, command);
  std::optional<Zones> zones;
  if (!arguments.zones.empty()) page.zones = &zones.emplace(readZones(arguments.zones));
  const auto words = installedAssociations(map.vocabulary, *makeStderrProgress());
  page.words = words.get();
  if (const WordGraph* graph = installedWordGraph()) page.lexicon = &graph->lexicon;
  const auto concepts = installedConcepts(map.vocabulary, arguments.naming);
  page.concepts = concepts.get();
  page.images.frames = store.imageFrames();
  page.images.read = [&store](std::size_t frame) { return store.image(frame); };
  writeMapPage(arguments.output, page);
  store.endReading();
}

void writeZones(const ReportArguments& arguments, const CLI::App& command) {
  for (const auto& [name, value] : {std::pair("--label", arguments.label), {"--zones", arguments.zones}})
    if (!value.empty())
      throw Error(ErrorCode::invalidOption,
                  fmt::format("{} goes with a map; {} holds zones", name, arguments.file));
  if (arguments.from)
    throw Error(ErrorCode::invalidOption,
                fmt::format("--from goes with a map; {} holds zones", arguments.file));
  const Zones zones = readZones(arguments.file);
  ZonesPage page{zones};
  page.title = titleOf(arguments);
  page.measures = measuresOf(evaluate(zones));
  const auto concepts = installedConcepts(zones.vocabulary, arguments.naming);
  page.concepts = concepts.get();
  if (!arguments.floorPlan.empty()) page.floorPlan = floorPlanOf(arguments, command);
  std::optional<MapStore> map;
  if (!arguments.map.empty()) {
    map.emplace(MapStore::open(arguments.map, MapStore::Access::read));
    overlayZones(zones, report::groupedRun(map->load()));  // throws where the map is of another run
    page.images = imagesOf(*map, zones.frames);
  }
  writeZonesPage(arguments.output, page);
}

void refuseOfMaps(const ReportArguments& arguments, const char* holds) {
  for (const auto& [name, given] : {std::pair("--label", !arguments.label.empty()),
                                    {"--zones", !arguments.zones.empty()},
                                    {"--floor-plan", !arguments.floorPlan.empty()},
                                    {"--from", arguments.from.has_value()}})
    if (given)
      throw Error(ErrorCode::invalidOption,
                  fmt::format("{} goes with a map; {} holds {}", name, arguments.file, holds));
}

/// The labels of a sequence: how often there are which.
void writeLabels(const ReportArguments& arguments) {
  refuseOfMaps(arguments, "labels");
  const DescriptorSequence labels = readDescriptors(arguments.file);
  std::optional<MapStore> map;
  ImageOfFrame image;
  if (!arguments.map.empty()) {
    map.emplace(MapStore::open(arguments.map, MapStore::Access::read));
    auto images = imagesOf(*map, labels.frames);
    if (images.frames.empty())
      throw Error(
          ErrorCode::mismatch,
          fmt::format("{} keeps no image of a frame of {}; make the map of the same images, or leave out "
                      "--map",
                      arguments.map, arguments.file));
    image = [images = std::move(images)](std::size_t frame) {
      return std::ranges::binary_search(images.frames, frame) ? images.read(frame)
                                                              : std::vector<unsigned char>();
    };
  }
  Findings findings = labelFindings(labels, image);
  findings.title = titleOf(arguments);
  writeFindingsPage(arguments.output, findings);
}

/// Views of objects: all objects at a glance, and their labels where there are some.
void writeObjects(const ReportArguments& arguments) {
  refuseOfMaps(arguments, "views of objects");
  if (!arguments.map.empty())
    throw Error(ErrorCode::invalidOption,
                fmt::format("--map gives images to labels; {} has its own", arguments.file));
  const auto views = openObjectViews(arguments.file);
  const auto crops = cropsOf(*views);
  Findings findings;
  Images sheet;
  if (const auto file = labelFileOf(arguments.file); std::filesystem::exists(file)) {
    const DescriptorSequence labels = readDescriptors(file);
    sheet = objectSheet(*views, &labels, *installedConcepts(labels.vocabulary, arguments.naming));
    std::map<std::string, std::size_t> viewNamed;
    for (std::size_t i = 0; i < views->size(); ++i) viewNamed.emplace(views->view(i).name, i);
    findings = labelFindings(labels, [&](std::size_t frame) {
      const auto view = viewNamed.find(labels.frames[frame].name);
      return view == viewNamed.end() ? std::vector<unsigned char>() : encodeImage(crops->image(view->second));
    });
  } else {
    sheet = objectSheet(*views);
  }
  findings.title = titleOf(arguments);
  findings.sections.insert(findings.sections.begin(), std::move(sheet));
  writeFindingsPage(arguments.output, findings);
}

void run(const ReportArguments& arguments, const CLI::App& command) {
  requireNoData(arguments.output, {arguments.file, arguments.map, arguments.zones, arguments.floorPlan},
                pageStart);
  requireReplaceable(arguments.output, arguments.overwrite, nullptr, "page");
  const bool objects = std::filesystem::is_directory(arguments.file);
  const bool zones = !objects && isZoneFile(arguments.file);
  const bool labels = !objects && isDescriptorFile(arguments.file);
  objects  ? writeObjects(arguments)
  : labels ? writeLabels(arguments)
  : zones  ? writeZones(arguments, command)
           : writeMap(arguments, command);
  if (arguments.json)
    print(nlohmann::ordered_json{{"file", arguments.output},
                                 {"shows", objects  ? "objects"
                                           : labels ? "labels"
                                           : zones  ? "zones"
                                                    : "map"},
                                 {"title", titleOf(arguments)}});
  else
    spdlog::info("wrote {}", arguments.output);
}

}  // namespace

void addReportCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "report", "Write a page that shows a map, zones, labels or objects: one HTML file, no network");
  auto arguments = std::make_shared<ReportArguments>(*command);
  command
      ->add_option(
          "FILE", arguments->file,
          "The map file (*.estancia), the file of zones (*.zones) or of labels (*.labels), or a folder of "
          "`estancia objects collect`")
      ->required();
  addOutputOption(*command, arguments->output, "The HTML file to write")->required();
  command->add_option("--title", arguments->title, "Title of the page; default: the file's name");
  command->add_option("--label", arguments->label,
                      "Start as the heat map of this label, or of the one that these words mean most");
  command
      ->add_option(
          "--floor-plan", arguments->floorPlan,
          "What to draw the map on: an image of the building, a home.json with its rooms, or a folder with "
          "a home.json, such as the drive's")
      ->check(CLI::ExistingPath);
  command
      ->add_option("--extent", arguments->extent,
                   "Edges of a floor plan that is an image, in the map [m]: XMIN YMIN XMAX YMAX")
      ->needs("--floor-plan");
  command->add_option("--zones", arguments->zones, "Lay these zones of the same run over the map")
      ->check(CLI::ExistingFile);
  command->add_option("--from", arguments->from,
                      "The place (a node number) where the ways to objects start; default: that of the first "
                      "frame");
  command
      ->add_option("--map", arguments->map,
                   "Show zones or labels with the images of this map of the same run")
      ->check(CLI::ExistingFile);
  arguments->declared.add(declare(arguments->naming), {"words"});
  addOverwriteOption(*command, arguments->overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia report home.estancia -o home.html\n"
              "  estancia report home.estancia -o home.html --label refrigerator\n"
              "  estancia report home.estancia -o home.html --from 7\n"
              "  estancia report home.estancia -o home.html --floor-plan ~/drive\n"
              "  estancia report home.estancia -o home.html --zones home.zones\n"
              "  estancia report home.zones -o zones.html --map home.estancia\n"
              "  estancia report home.labels -o labels.html --map home.estancia\n"
              "  estancia report samples -o objects.html");
  command->callback([arguments, command] { run(*arguments, *command); });
}

}  // namespace estancia::apps
