// estancia route: the way to a place, an area, an object or a word.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <numbers>
#include <utility>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "own_words.hpp"

namespace estancia::apps {
namespace {

struct RouteArguments {
  explicit RouteArguments(CLI::App& command) : declared(command) {}
  std::string map, to, dictionary;
  int from = 0;
  RegionPreferences preferences;
  RouteOptions options;
  DeclaredOptions declared;
  bool json = false;
};

/// `--to 7` names a node, `--to coffee` what should be there.
std::optional<int> nodeNumber(const std::string& text) {
  int id = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return id;
}

WorldRoute routeOf(const RouteArguments& arguments, const WorldMap& world) {
  if (const auto node = nodeNumber(arguments.to))
    return routeInWorld(world, arguments.from, *node, arguments.preferences, arguments.options,
                        installedWordGraph);
  return routeInWorld(world, arguments.from, arguments.to, arguments.preferences, arguments.options,
                      installedWordGraph);
}

/// What words stand for that are no names.
void printUnderstood(const WorldRoute& found, const RouteArguments& arguments, const Vocabulary& vocabulary) {
  const auto isInOtherWords = [](const Meaning& meaning) {
    return !meaning.corrected.empty() || std::ranges::any_of(meaning.matches, [](const LabelMatch& match) {
      return !match.reason.empty();
    });
  };
  const auto textOf = [&](const std::string& words, const Meaning& meaning) {
    return fmt::format("{} → {}", printable(meaning.corrected.empty() ? words : meaning.corrected),
                       fmt::join(describeMeaning(meaning, vocabulary), ", "));
  };
  if (isInOtherWords(found.meaning)) fmt::print("{}\n", textOf(arguments.to, found.meaning));
  for (const auto& [use, regions] :
       {std::pair("avoid", &found.regions.avoid), std::pair("prefer", &found.regions.prefer)})
    for (const MapRegion& region : *regions) {
      if (region.meaning.empty()) continue;
      const auto places = std::ranges::count(region.places, true);
      if (places == 0)
        spdlog::warn("--{} {} changes nothing: no place is likely to hold it", use, printable(region.name));
      if (places == 0 || isInOtherWords(region.meaning))
        fmt::print("{} {} ({})\n", use, textOf(region.name, region.meaning),
                   report::counted(static_cast<std::size_t>(places), "place"));
    }
}

void printGoal(const WorldRoute& found, const RouteArguments& arguments, const WorldMap& world) {
  if ((found.object && !found.object->isLikely()) || (found.place && !found.place->isLikely()))
    spdlog::warn("no {} is likely to {} \"{}\"; this is the most probable one",
                 found.object ? "object" : "place", found.object ? "be" : "hold", printable(arguments.to));
  if (found.area >= 0) fmt::print("area {} ({})\n", found.area, world.findArea(found.area)->displayName());
  if (found.object) {
    const WorldObject& object = *world.findObject(found.object->object);
    std::string on = supportText(object, world);
    for (const std::string& more : {knownText(object), shapeText(object)})
      if (!more.empty()) on += (on.empty() ? "" : ", ") + more;
    fmt::print("\"{}\" is object {} ({:.1f} %) at ({:.2f}, {:.2f}, {:.2f}) m{}\n", object.displayName(),
               object.id, 100 * found.object->probability, object.center.x, object.center.y, object.center.z,
               on.empty() ? "" : ", " + on);
  }
  if (found.place)
    fmt::print("\"{}\" is at place {} ({:.1f} %)\n",
               found.place->room.empty() ? shortLabel(world.places.vocabulary[found.place->label])
                                         : found.place->room,
               found.place->node, 100 * found.place->probability);
}

void printRoute(const WorldRoute& found, const WorldMap& world) {
  const std::vector<Place> places = placesOf(world.places);
  std::vector<std::string> steps;
  for (const int node : found.route.nodes) {
    std::string name = places[indexOf(world.places, node)].displayRoom();
    if (const WorldArea* area = world.findArea(world.areaOfNode(node)); area != nullptr && name.empty())
      name = area->displayName();
    steps.push_back(name.empty() ? std::to_string(node) : fmt::format("{} ({})", node, name));
  }
  fmt::print("{}\n{}\n", fmt::join(steps, " → "),
             found.driven         ? fmt::format("{:.1f} m as driven", found.driven->length)
             : found.route.metric ? fmt::format("{:.1f} m", found.route.cost)
                                  : fmt::format("{:.0f} {}", found.route.cost,
                                                found.route.cost == 1 ? "transition" : "transitions"));
  if (const auto& pose = found.pose)
    fmt::print("there stand at ({:.2f}, {:.2f}) m, yaw {:.0f}° ({}), {:.1f} m from it\n", pose->x, pose->y,
               pose->yaw * 180 / std::numbers::pi, world.places.frames[pose->frame].name, pose->distance);
}

void run(RouteArguments& arguments) {
  const WorldMap world = readWorld(arguments.map, maxFramesOfAnswers);
  arguments.to = inEnglish(arguments.to, arguments.dictionary, world);
  for (auto* regions : {&arguments.preferences.avoid, &arguments.preferences.prefer})
    for (std::string& region : *regions) region = inEnglish(region, arguments.dictionary, world);
  WorldRoute found;
  try {
    found = routeOf(arguments, world);
  } catch (const NoAnswerError& why) {
    if (arguments.json)
      print({{"from", arguments.from},
             {"to", nullptr},
             {"nodes", nlohmann::json::array()},
             {"why", why.what()}});
    else
      fmt::print("No way: {}\n", why.what());
    throw NoAnswer{};
  }
  if (arguments.json) return print(toJson(nodeNumber(arguments.to) ? "" : arguments.to, found, world));
  printUnderstood(found, arguments, world.places.vocabulary);
  printGoal(found, arguments, world);
  printRoute(found, world);
  for (const CrossedRegion& crossed : found.crossed)
    fmt::print("{}\n", crossedText(crossed, arguments.options));
}

}  // namespace

void addRouteCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("route", "Find the way to a place, an area, an object, or to where a word is");
  auto arguments = std::make_shared<RouteArguments>(*command);
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("--from", arguments->from, "The place to start from (a node number)")->required();
  command
      ->add_option("--to", arguments->to,
                   "A node number, the name that an area or object was given, or words to look for")
      ->required();
  const std::string region = " (its number, its name, or words that are likely there); may be repeated";
  command
      ->add_option("--avoid", arguments->preferences.avoid,
                   "An area to go around where the detour is not too long" + region +
                       ". It is never out of reach, only dearer: --avoid-factor")
      ->allow_extra_args(false);
  command
      ->add_option("--prefer", arguments->preferences.prefer,
                   "An area to go through where that is not too long: --prefer-factor" + region)
      ->allow_extra_args(false);
  arguments->declared.add(declare(arguments->options),
                          {"bidirectional=one-way", "tolerance", "avoid-factor", "prefer-factor"});
  addDictionaryOption(*command, arguments->dictionary);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia route home.estancia --from 0 --to umbrella\n"
              "  estancia route home.estancia --from 3 --to 12 --json\n"
              "  estancia route home.estancia --from 0 --to mug --avoid bathroom --prefer corridor");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
