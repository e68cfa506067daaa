// Map region: a part of a map that a robot behaves differently in (thesis 5.6), by its name.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/driven_way.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world_file/area_names.hpp"
#include "estancia/world_file/edit_rules.hpp"

namespace estancia {
namespace {

bool isNumber(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

[[noreturn]] void failUnknownRegion(const WorldMap& world, const std::string& text, WordGraphSource source) {
  std::vector<std::string> known;
  for (const WorldArea& area : world.areas)
    known.push_back(fmt::format("{} ({})", area.id, area.displayName()));
  fail(ErrorCode::unknownName, "the map has no area, room or label \"{}\"{}{}", printable(text),
       known.empty() ? "" : fmt::format("; its areas are {}", fmt::join(known, ", ")),
       missingWordsHint(source));
}

MapRegion regionNamed(const WorldMap& world, const std::string& text, WordGraphSource source) {
  MapRegion region{text, areasCalled(world, text)};
  if (const WorldArea* found = findAreaNumber(world, text); found != nullptr && region.areas.empty())
    region.areas.push_back(found->id);
  if (!region.areas.empty()) return region;
  const TopologicalMap& map = world.places;
  const std::vector<Place> places = placesOf(map);
  for (const Place& place : places) region.places.push_back(sameWords(place.displayRoom(), text));
  if (std::ranges::find(region.places, true) != region.places.end()) return region;
  if (isNumber(text)) getArea(world, text);  // throws, listing the areas
  const WorldMeaning meaning = findMeaning(world, text, source);
  if (meaning.isWholeName) return {text, meaning.areas};
  if (meaning.Meaning::empty()) failUnknownRegion(world, text, source);
  region.meaning = meaning;
  for (const PlaceAnswer& answer : placesThatHold(meaning, map, map.nodes.size()))
    region.places[indexOf(map, answer.node)] = answer.isLikely() && answer.lift > 1;
  return region;
}

bool isInAny(const std::vector<MapRegion>& regions, std::size_t place, int area) {
  return std::ranges::any_of(regions, [&](const MapRegion& region) { return region.holds(place, area); });
}

}  // namespace

bool MapRegion::holds(std::size_t place, int area) const {
  if (places.empty()) return std::ranges::find(areas, area) != areas.end();
  return places[place];
}

double RegionCosts::at(std::size_t place, int area) const {
  return (isInAny(avoid, place, area) ? avoidFactor : 1) * (isInAny(prefer, place, area) ? preferFactor : 1);
}

RegionCosts regionCosts(const WorldMap& world, const RegionPreferences& preferences,
                        const RouteOptions& options, WordGraphSource source) {
  RegionCosts costs{{}, {}, options.avoidFactor, options.preferFactor};
  for (const std::string& name : preferences.avoid) costs.avoid.push_back(regionNamed(world, name, source));
  for (const std::string& name : preferences.prefer) costs.prefer.push_back(regionNamed(world, name, source));
  return costs;
}

}  // namespace estancia
