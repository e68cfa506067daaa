// estancia ask: which places hold a word?
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/report/node_zones.hpp"
#include "estancia/topology/ask.hpp"
#include "estancia/topology/map_json.hpp"
#include "estancia/topology/places.hpp"
#include "estancia/zones/overlay.hpp"
#include "estancia/zones/zone_file.hpp"

namespace estancia::apps {
namespace {

struct AskArguments {
  std::string map, words, zones;
  std::size_t maxPlaces = 5;
  bool json = false;
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

void run(const AskArguments& arguments) {
  const TopologicalMap map = readMap(arguments.map);
  const PlacesInZones zones(arguments.zones, map);
  if (findMeaning(map, arguments.words).empty()) {
    const auto near = findNearSpellings(map.vocabulary, arguments.words);
    if (arguments.json)
      print({{"words", arguments.words},
             {"labels", nlohmann::json::array()},
             {"rooms", nlohmann::json::array()},
             {"near_spellings", near},
             {"places", nlohmann::json::array()}});
    else
      fmt::print("No label of the map means \"{}\".{}\n", printable(arguments.words),
                 near.empty() ? "" : fmt::format(" Did you mean {}?", fmt::join(near, ", ")));
    throw NoAnswer{};
  }
  const Answers answers = ask(map, arguments.words, arguments.maxPlaces);
  const std::vector<Place> places = placesOf(map);
  if (arguments.json) {
    nlohmann::ordered_json json = toJson(arguments.words, answers, map, places);
    for (auto& place : json["places"])
      if (const Zone* zone = zones.find(place["node"]))
        place["zone"] = {{"id", zone->id}, {"name", zone->name}};
    return print(json);
  }
  std::vector<std::string> matched;
  for (const std::size_t label : answers.labels) matched.push_back(shortLabel(map.vocabulary[label]));
  for (const std::string& room : answers.rooms) matched.push_back("room " + room);
  fmt::print("{} → {}\n", printable(arguments.words), fmt::join(matched, ", "));
  if (std::ranges::none_of(answers.places, &PlaceAnswer::isLikely))
    fmt::print("{}; the most probable are\n", answers.rooms.empty()
                                                  ? "No place has it among its five best words"
                                                  : "No place is most probably that room");
  for (const PlaceAnswer& answer : answers.places) {
    const Zone* zone = zones.find(answer.node);
    fmt::print("place {:<5} {:>5.1f} %  {:>5.1f}× the map's mean  {}{}{}\n", answer.node,
               100 * answer.probability, answer.lift, reasonOf(answer, map),
               roomOf(places[indexOf(map, answer.node)]),
               zone == nullptr ? "" : fmt::format("  in zone {} ({})", zone->id, zone->name));
  }
}

}  // namespace

void addAskCommand(CLI::App& app) {
  auto arguments = std::make_shared<AskArguments>();
  CLI::App* command = app.add_subcommand("ask", "Ask a map for a word: which places hold it?");
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("WORDS", arguments->words, "What to look for: a label, a synonym or a part of one")
      ->required();
  command->add_option("-n,--max-places", arguments->maxPlaces, "Largest number of places to list")
      ->capture_default_str()
      ->check(positive());
  command->add_option("--zones", arguments->zones,
                      "Zones of the same run (`estancia zones find MAP`): say which zone each place is in");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia ask home.estancia umbrella\n"
              "  estancia ask home.estancia \"coffee mug\" --json\n"
              "  estancia ask home.estancia umbrella --zones home.zones");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
