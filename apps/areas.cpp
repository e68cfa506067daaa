// estancia areas: images with depth and poses → the rooms of a floor plan.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "command_tree.hpp"
#include "common.hpp"
#include "estancia/areas/areas.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/figures/annotated_image.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_choice.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_query/world_json.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/zones.hpp"
#include "labeling.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

struct AreasArguments {
  explicit AreasArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  ModelArguments model;
  AreaOptions options;
  DeclaredOptions declared;
  std::string output, image, word;
  bool overwrite = false, json = false;
};

/// The frames that have words.
DescriptorSequence labeled(Labeling& labeling) {
  DescriptorSequence result{
      labeling.vocabulary(), labeling.identity(), {}, DescriptorMatrix(labeling.vocabulary().size())};
  labeling.forEach(0, "labeling", [&](const LabeledFrame& frame) {
    result.frames.push_back(labeling.sequence().frame(frame.index));
    result.descriptors.append(frame.descriptor);
  });
  return result;
}

/// What --word means: all labels of that name, else those that are meant more probably than not, at least the
/// most probable. Reports which. Throws Error where there is none.
std::vector<std::size_t> labelsOf(const Vocabulary& vocabulary, const std::string& word) {
  constexpr double minProbability = 0.5;
  LabelMatches found = chooseLabels(vocabulary, word, installedWordGraph);
  if (found.labels.empty()) {
    const std::vector<std::string> near = findNearSpellings(vocabulary, word);
    throw Error(
        ErrorCode::unknownName,
        fmt::format("--word: none of {} labels matches \"{}\"{}", vocabulary.size(), printable(word),
                    near.empty() ? "; give another word"
                                 : fmt::format("; did you mean \"{}\"?", fmt::join(near, "\" or \""))));
  }
  const auto isUnsure = [](const LabelMatch& match) { return match.probability < minProbability; };
  found.labels.erase(std::find_if(found.labels.begin() + 1, found.labels.end(), isUnsure),
                     found.labels.end());
  if (!found.labels.front().reason.empty() || !found.corrected.empty())
    spdlog::info("no label is called \"{}\": taken are {}", printable(word),
                 fmt::join(describeMatches(vocabulary, found.labels), ", "));
  std::vector<std::size_t> labels;
  for (const LabelMatch& match : found.labels) labels.push_back(match.label);
  return labels;
}

/// The cell that a word is most sure to be in.
struct Strongest {
  double x = 0, y = 0, value = 0;
  int area = -1;
};

/// Nothing where the word was never seen.
std::optional<Strongest> strongestOf(const FloorHeat& heat, const Areas& areas) {
  cv::Point best;
  Strongest strongest;
  cv::minMaxLoc(heat.values, nullptr, &strongest.value, nullptr, &best);
  if (!(strongest.value > 0)) return std::nullopt;
  const cv::Point2d at = heat.cells.centerOf(best);
  strongest.x = at.x;
  strongest.y = at.y;
  double nearest = 1;  // [m] things stand at walls, beside the free floor
  for (int row = 0; row < areas.areaOf.rows; ++row)
    for (int column = 0; column < areas.areaOf.cols; ++column)
      if (const double d = cv::norm(areas.cells.centerOf({column, row}) - at);
          d < nearest && areas.areaOf.at<int>(row, column) >= 0) {
        nearest = d;
        strongest.area = areas.areaOf.at<int>(row, column);
      }
  return strongest;
}

Json areaJson(const Area& area) {
  Json outline = Json::array();
  for (const cv::Point2d& corner : area.outline) outline.push_back({corner.x, corner.y});
  return {{"id", area.id},         {"name", area.name},
          {"size", area.size},     {"center", {area.center.x, area.center.y}},
          {"frames", area.frames}, {"outline", std::move(outline)}};
}

void printJson(const AreasArguments& arguments, const Areas& areas, const std::vector<Measure>& measures,
               const std::optional<Strongest>& strongest) {
  Json json{{"file", arguments.output}, {"areas", Json::array()}, {"frames", Json::array()}};
  for (const Area& area : areas.areas) json["areas"].push_back(areaJson(area));
  for (std::size_t i = 0; i < areas.zones.frames.size(); ++i)
    json["frames"].push_back({{"image", areas.zones.frames[i].name}, {"area", areas.zones.zoneOf[i]}});
  if (!arguments.word.empty())
    json["word"] = {{"word", arguments.word},
                    {"position", strongest ? Json{strongest->x, strongest->y} : Json()},
                    {"p", strongest ? strongest->value : 0},
                    {"area", strongest && strongest->area >= 0 ? Json(strongest->area) : Json()}};
  json["measures"] = toJson(measures);
  print(json);
}

void printTable(const AreasArguments& arguments, const Areas& areas, const std::vector<Measure>& measures,
                const std::optional<Strongest>& strongest) {
  fmt::print("{}: {} of {}\n\n", printable(arguments.output), counted(areas.areas.size(), "area"),
             counted(areas.zones.frames.size(), "frame"));
  fmt::print("area  frames     size  center [m]      words\n");
  for (const Area& area : areas.areas) {
    const auto* zone = area.frames > 0 ? &areas.zones.zones[area.id] : nullptr;
    const std::string room = zone == nullptr || zone->room.empty()
                                 ? (zone == nullptr ? "  (only seen)" : "")
                                 : fmt::format("  ({}, {:.0f} %)", zone->room, 100 * zone->roomShare);
    fmt::print("{:>4}  {:>6}  {:>4.1f} m²  {:>6.2f} {:>6.2f}   {}{}\n", area.id, area.frames, area.size,
               area.center.x, area.center.y, area.name, room);
  }
  if (!arguments.word.empty() && !strongest) fmt::print("\n\"{}\" was not seen\n", printable(arguments.word));
  if (strongest)
    fmt::print("\n\"{}\" is most sure at ({:.2f}, {:.2f}) m{}: {:.2f}\n", printable(arguments.word),
               strongest->x, strongest->y,
               strongest->area < 0 ? "" : fmt::format(", in area {}", strongest->area), strongest->value);
  fmt::print("\n");
  print(measures);
}

void run(const AreasArguments& arguments) {
  validate(arguments.options);  // before anything is labeled
  const std::string& path = arguments.sequence.path;
  requireReplaceable(arguments.output, arguments.overwrite, isZoneFile, "zone file");
  requireImage(arguments.image, arguments.overwrite, {path});
  Labeling labeling(arguments.sequence, arguments.model);
  if (!labeling.sequence().hasDepth())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{} has no depth images, which show walls and doors; `estancia zones find` "
                            "groups images by their words alone",
                            printable(path)));
  const std::vector<std::size_t> labels =
      arguments.word.empty() ? std::vector<std::size_t>() : labelsOf(labeling.vocabulary(), arguments.word);
  const DescriptorSequence words = labeled(labeling);
  const Areas areas = findAreas(labeling.sequence(), words, arguments.options, *makeStderrProgress());
  writeZones(areas.zones, arguments.output);
  std::optional<FloorHeat> heat;
  std::optional<Strongest> strongest;
  if (!labels.empty()) {
    heat = areas.words.heat(labels);
    strongest = strongestOf(*heat, areas);
  }
  if (!arguments.image.empty())
    writePng(report::drawFloorPlan(areas, heat ? &*heat : nullptr), arguments.image);
  const std::vector<Measure> measures = measuresOf(evaluate(areas.zones));
  if (arguments.json)
    printJson(arguments, areas, measures, strongest);
  else
    printTable(arguments, areas, measures, strongest);
}

}  // namespace

namespace {

void addFindCommand(CLI::App& group) {
  CLI::App* command = group.add_subcommand(
      "find", "Find the rooms of a drive: split free space at doors, name each room by what is seen in it");
  auto arguments = std::make_shared<AreasArguments>(*command);
  arguments->sequence.addTo(arguments->declared);
  arguments->sequence.addDepthTo(arguments->declared);
  addOutputOption(*command, arguments->output, "The frames by area, as a file of zones, NAME.zones")
      ->required();
  arguments->model.addTo(arguments->declared, "The model that labels the images");
  command->add_option("--render", arguments->image, "Draw the floor plan with its areas (PNG)")
      ->type_name("FILE");
  command->add_option("--word", arguments->word, "Where on the floor this word is; --render shows its heat");
  addOverwriteOption(*command, arguments->overwrite);
  arguments->declared.add(declare(arguments->options), {"naming.words"});
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia areas find ~/home -o home.zones\n"
              "  estancia areas find ~/home -o home.zones --render plan.png\n"
              "  estancia areas find ~/home -o home.zones --word refrigerator --render heat.png");
  command->callback([arguments] { run(*arguments); });
}

struct EditArguments {
  std::string map, area, other, name;
  double fromX = 0, fromY = 0, toX = 0, toY = 0;
  bool json = false;
};

/// The areas of a map: corrections may number them anew.
void printAreas(const EditArguments& arguments) {
  const WorldMap world = readWorld(arguments.map);
  if (!arguments.json) fmt::print("{}: {}\n", printable(arguments.map), counted(world.areas.size(), "area"));
  Json areas = Json::array();
  for (const WorldArea& area : world.areas) {
    const auto objects =
        static_cast<std::size_t>(std::ranges::count(world.objects, area.id, &WorldObject::area));
    if (!arguments.json)
      fmt::print("  {:>2}  {:<40} {:>6.1f} m²  {:>12}  {:>11}\n", area.id, area.describedName(), area.size,
                 counted(area.frames, "frame"), counted(objects, "object"));
    areas.push_back(toJson(area));
    areas.back()["objects"] = objects;
  }
  if (arguments.json) print(Json{{"map", arguments.map}, {"areas", areas}});
}

void addListCommand(CLI::App& group) {
  CLI::App* command = group.add_subcommand("list", "List the areas of a map: numbers, names, sizes");
  auto arguments = std::make_shared<EditArguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia areas list home.estancia");
  command->callback([arguments] { printAreas(*arguments); });
}

void addMergeCommand(CLI::App& group) {
  CLI::App* command = group.add_subcommand("merge", "Make two areas of a map one");
  auto arguments = std::make_shared<EditArguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("AREA", arguments->area, "Its number or name")->required();
  command->add_option("OTHER", arguments->other, "Number or name of the other one")->required();
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia areas merge home.estancia 4 6");
  command->callback([arguments] {
    mergeAreas(arguments->map, arguments->area, arguments->other, *makeStderrProgress());
    printAreas(*arguments);
  });
}

void addSplitCommand(CLI::App& group) {
  CLI::App* command = group.add_subcommand("split", "Split an area of a map along a line across it");
  auto arguments = std::make_shared<EditArguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("X1", arguments->fromX, "Where the line begins [m]")->required();
  command->add_option("Y1", arguments->fromY, "")->required();
  command->add_option("X2", arguments->toX, "Where it ends [m]")->required();
  command->add_option("Y2", arguments->toY, "")->required();
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia areas split home.estancia 3.5 0 3.5 4");
  command->callback([arguments] {
    splitArea(arguments->map, {arguments->fromX, arguments->fromY}, {arguments->toX, arguments->toY},
              *makeStderrProgress());
    printAreas(*arguments);
  });
}

}  // namespace

void addAreasCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("areas", "Find areas: the rooms of a drive with depth and poses");
  group->require_subcommand(1);
  addExamples(*group,
              "  estancia areas find ~/home -o home.zones --render plan.png\n"
              "  estancia areas merge home.estancia 4 6");
  addFindCommand(*group);
  addListCommand(*group);
  addMergeCommand(*group);
  addSplitCommand(*group);
}

void addNameCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("name", "Name an area of a map");
  auto arguments = std::make_shared<EditArguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("AREA", arguments->area, "Its number, or the name it has")->required();
  command
      ->add_option("NAME", arguments->name,
                   "What people call it, kept when the areas are found again; \"\" takes the name away")
      ->type_name(textOrNothing)
      ->required();
  addJsonOption(*command, arguments->json);
  addExamples(*command, "  estancia name home.estancia 2 \"music room\"");
  command->callback([arguments] {
    nameArea(arguments->map, arguments->area, arguments->name);
    printAreas(*arguments);
  });
}

}  // namespace estancia::apps
