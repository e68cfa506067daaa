// estancia ask: which objects, areas and places does a word mean?
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "estancia/zones/naming.hpp"
#include "estancia/zones/overlay.hpp"
#include "estancia/zones/zones.hpp"
#include "own_words.hpp"

namespace estancia::apps {
namespace {

struct AskArguments {
  std::string map, words, zones, images, dictionary;
  std::size_t maxPlaces = 5, maxObjects = 5;
  bool json = false, overwrite = false;
};

/// The zones of the map's places, if a file of them was given.
class PlacesInZones {
 public:
  PlacesInZones(const std::string& file, const TopologicalMap& map) {
    if (file.empty()) return;
    zones_ = readZones(file);
    places_ = overlayZones(*zones_, report::groupedRun(map));
  }

  /// nullptr when nothing is known of the place.
  const Zone* find(int node) const {
    const GroupZones* place = findGroup(places_, node);
    return place == nullptr ? nullptr : &zones_->zones[static_cast<std::size_t>(place->zone())];
  }

 private:
  std::optional<Zones> zones_;
  std::vector<GroupZones> places_;
};

std::string reasonOf(const PlaceAnswer& answer, const TopologicalMap& map) {
  return answer.room.empty()
             ? fmt::format("\"{}\" is its word no. {}", shortLabel(map.vocabulary[answer.label]), answer.rank)
             : fmt::format("\"{}\" is its room no. {}", answer.room, answer.rank);
}

std::string roomOf(const Place& place) {
  const std::string room = place.displayRoom();
  return room.empty() ? "" : "  (" + room + ")";
}

void printNothing(const AskArguments& arguments, const WorldMap& world) {
  const auto near = findNearNames(world, arguments.words);
  if (!arguments.json) {
    fmt::print("No label of the map means \"{}\".{}{}\n", printable(arguments.words),
               near.empty() ? "" : fmt::format(" Did you mean {}?", fmt::join(near, ", ")),
               missingWordsHint(installedWordGraph));
    return;
  }
  nlohmann::ordered_json json = toJson(arguments.words, WorldAnswers{}, world);
  json["near_spellings"] = near;
  print(json);
}

void makeFolder(const std::string& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem)
    throw Error(ErrorCode::fileUnwritable,
                fmt::format("cannot make the folder {}: {}", folder, problem.message()));
}

/// Writes the image of each object that has one into the folder; their files, "" for none.
std::vector<std::string> writeImages(const AskArguments& arguments, const WorldAnswers& answers) {
  std::vector<std::string> files;
  for (const ObjectAnswer& answer : answers.objects) {
    files.emplace_back();
    if (arguments.images.empty()) continue;
    const auto jpeg = readObjectImage(arguments.map, answer.object);
    if (jpeg.empty()) continue;
    const auto file = std::filesystem::path(arguments.images) / fmt::format("object-{}.jpg", answer.object);
    makeFolder(arguments.images);
    requireReplaceable(file, arguments.overwrite, nullptr, "ask");
    writeWhole(file, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
    files.back() = file;
  }
  return files;
}

std::string areaText(const WorldMap& world, int area) {
  const WorldArea* found = world.findArea(area);
  return found == nullptr ? "" : fmt::format("in area {} ({})", area, found->displayName());
}

/// "000211.jpg", and of which drive where there are several.
std::string momentText(const TopologicalMap& map, std::size_t frame) {
  if (map.drives.size() < 2) return map.frames[frame].name;
  return fmt::format("{} of {}", map.frames[frame].name, describeDrive(map, map.driveOf(frame)));
}

void printObject(const ObjectAnswer& answer, const WorldMap& world, const std::string& image) {
  const WorldObject& object = *world.findObject(answer.object);
  std::string where =
      fmt::format("at ({:.2f}, {:.2f}, {:.2f}) m", object.center.x, object.center.y, object.center.z);
  for (const std::string& more :
       {supportText(object, world), areaText(world, object.area), knownText(object), shapeText(object)})
    if (!more.empty()) where += ", " + more;
  const std::string reason =
      answer.isNamed   ? "named so"
      : answer.isKnown ? "recognized as it"
      : answer.isShaped && answer.rank != 1
          ? "of that class by its shape"
          : fmt::format("\"{}\" is its word no. {}", shortLabel(answer.label), answer.rank);
  fmt::print(
      "object {:<4} {:>5.1f} %  {:>5.1f}× the objects' mean  {}: {}  {}; seen in {} images, {} to {}{}\n",
      answer.object, 100 * answer.probability, answer.lift, object.displayName(), reason, where, object.views,
      momentText(world.places, object.firstFrame), momentText(world.places, object.lastFrame),
      image.empty() ? "" : "; " + image);
}

void printPlaces(const WorldAnswers& answers, const WorldMap& world, const PlacesInZones& zones) {
  const std::vector<Place> places = placesOf(world.places);
  if (!answers.places.empty() && std::ranges::none_of(answers.places, &PlaceAnswer::isLikely))
    fmt::print("{}; the most probable are\n", answers.rooms.empty()
                                                  ? "No place has it among its five best words"
                                                  : "No place is most probably that room");
  for (const PlaceAnswer& answer : answers.places) {
    const Zone* zone = zones.find(answer.node);
    const std::string area = areaText(world, world.areaOfNode(answer.node));
    fmt::print("place {:<5} {:>5.1f} %  {:>5.1f}× the map's mean  {}{}{}{}\n", answer.node,
               100 * answer.probability, answer.lift, reasonOf(answer, world.places),
               roomOf(places[indexOf(world.places, answer.node)]), area.empty() ? "" : "  " + area,
               zone == nullptr ? "" : fmt::format("  in zone {} ({})", zone->id, describedName(*zone)));
  }
}

void printAnswers(const WorldAnswers& answers, const WorldMap& world, const std::vector<std::string>& images,
                  const std::string& words) {
  std::vector<std::string> matched = describeMeaning(answers, world.places.vocabulary);
  const std::string part = answers.isWholeName ? "" : "a part of ";
  const auto isGiven = [&world](int area) { return !world.findArea(area)->givenName.empty(); };
  if (std::ranges::any_of(answers.areas, isGiven)) matched.push_back(part + "an area's name by people");
  if (!std::ranges::all_of(answers.areas, isGiven))
    matched.push_back(part + (world.places.predictions->areByName ? "an area's name by what was seen there"
                                                                  : "an area's name by a room classifier"));
  if (!answers.namedObjects.empty()) matched.emplace_back("an object's name by people");
  if (!answers.knownObjects.empty()) matched.emplace_back("a known object");
  if (!answers.shapedObjects.empty()) matched.emplace_back("a class of the object model");
  fmt::print("{} → {}\n", printable(answers.corrected.empty() ? words : answers.corrected),
             fmt::join(matched, ", "));
  for (const int id : answers.areas) {
    const WorldArea& area = *world.findArea(id);
    fmt::print("area {} ({}): {:.1f} m² around ({:.2f}, {:.2f}) m, {} images\n", area.id, area.displayName(),
               area.size, area.center.x, area.center.y, area.frames);
  }
  if (!answers.objects.empty() && std::ranges::none_of(answers.objects, &ObjectAnswer::isLikely))
    fmt::print("No object has it as its best word; the most probable are\n");
  for (std::size_t i = 0; i < answers.objects.size(); ++i) printObject(answers.objects[i], world, images[i]);
}

WorldAnswers answersOrNothing(const AskArguments& arguments, const WorldMap& world) {
  try {
    return askWorld(world, arguments.words, arguments.maxPlaces, arguments.maxObjects, installedWordGraph);
  } catch (const NoAnswerError&) {
    printNothing(arguments, world);
    throw NoAnswer{};
  }
}

void run(AskArguments arguments) {
  const WorldMap world = arguments.zones.empty() ? readWorld(arguments.map, maxFramesOfAnswers)
                                                 : readWorld(arguments.map);  // zones have all its frames
  arguments.words = inEnglish(arguments.words, arguments.dictionary, world);
  const PlacesInZones zones(arguments.zones, world.places);
  const WorldAnswers answers = answersOrNothing(arguments, world);
  const std::vector<std::string> images = writeImages(arguments, answers);
  if (!arguments.json) {
    printAnswers(answers, world, images, arguments.words);
    printPlaces(answers, world, zones);
    return;
  }
  nlohmann::ordered_json json = toJson(arguments.words, answers, world);
  for (std::size_t i = 0; i < images.size(); ++i)
    if (!images[i].empty()) json["objects"][i]["image_file"] = images[i];
  for (auto& place : json["places"])
    if (const Zone* zone = zones.find(place["node"]))
      place["zone"] = {{"id", zone->id}, {"name", zone->name}};
  print(json);
}

}  // namespace

void addAskCommand(CLI::App& app) {
  auto arguments = std::make_shared<AskArguments>();
  CLI::App* command =
      app.add_subcommand("ask", "Ask a map for a word: which objects, areas and places does it mean?");
  command->add_option("MAP", arguments->map, "The map file")->required();
  command
      ->add_option(
          "WORDS", arguments->words,
          "What to look for, in your own words, or the name of an area or object; several words in quotation "
          "marks")
      ->required();
  command->add_option("-n,--max-places", arguments->maxPlaces, "Largest number of places to list")
      ->capture_default_str()
      ->check(wholeNumber(1));
  command->add_option("--max-objects", arguments->maxObjects, "Largest number of objects to list")
      ->capture_default_str()
      ->check(wholeNumber(1));
  command->add_option("--images", arguments->images,
                      "Folder to write the images of these objects into: object-NUMBER.jpg");
  addOverwriteOption(*command, arguments->overwrite);
  command->add_option("--zones", arguments->zones,
                      "Zones of the same run (`estancia zones find MAP`): say which zone each place is in");
  addDictionaryOption(*command, arguments->dictionary);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia ask home.estancia umbrella\n"
              "  estancia ask home.estancia \"coffee mug\" --json\n"
              "  estancia ask home.estancia \"something to sit on\"\n"
              "  estancia ask home.estancia mug --images mugs\n"
              "  estancia ask home.estancia umbrella --zones home.zones");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
