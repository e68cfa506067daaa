// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/area_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/room_predictions.hpp"

namespace estancia {
namespace {

/// More probable than all other rooms together.
constexpr double surely = 0.5;

bool isNamedByRoom(const WorldArea& area) {
  return area.givenName.empty() && !area.predictedRoom.empty() && area.roomProbability > surely;
}

}  // namespace

void nameAreasByRooms(WorldMap& world) {
  if (!world.places.predictions) return;
  std::vector<std::size_t> areaOf;
  for (const int area : world.areaOfFrame)
    areaOf.push_back(area < 0 ? world.areas.size() : static_cast<std::size_t>(area));
  const auto pooled = poolRooms(*world.places.predictions, areaOf, world.areas.size());
  std::map<std::string, int> areasOfRoom;
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    if (pooled[i].empty()) continue;
    WorldArea& area = world.areas[i];
    area.predictedRoom = printable(pooled[i].front().room);
    area.roomProbability = pooled[i].front().probability;
    if (isNamedByRoom(area)) ++areasOfRoom[area.predictedRoom];
  }
  const auto isGiven = [&world](const std::string& name) {
    return std::ranges::any_of(world.areas,
                               [&](const WorldArea& area) { return sameWords(area.givenName, name); });
  };
  std::map<std::string, int> number;
  for (WorldArea& area : world.areas) {
    if (!isNamedByRoom(area)) continue;
    const std::string& room = area.predictedRoom;
    area.roomName = room;
    if (areasOfRoom[room] == 1 && !isGiven(room)) continue;
    if (isGiven(room)) number.emplace(room, 1);  // that area is the first one
    do area.roomName = fmt::format("{} {}", room, ++number[room]);
    while (isGiven(area.roomName));
  }
}

std::vector<int> areasNamed(const WorldMap& world, const std::string& text) {
  for (const std::string WorldArea::*name : {&WorldArea::givenName, &WorldArea::roomName}) {
    std::vector<int> areas;
    for (const WorldArea& area : world.areas)
      if (sameWords(area.*name, text)) areas.push_back(area.id);
    if (!areas.empty()) return areas;
  }
  std::vector<int> areas;
  for (const WorldArea& area : world.areas)
    if (isNamedByRoom(area) && sameWords(area.predictedRoom, text)) areas.push_back(area.id);
  return areas;
}

std::vector<int> areasCalled(const WorldMap& world, const std::string& text) {
  std::vector<int> areas = areasNamed(world, text);
  if (!areas.empty()) return areas;
  for (const WorldArea& area : world.areas)
    if (sameWords(area.name, text)) areas.push_back(area.id);
  return areas;
}

}  // namespace estancia
