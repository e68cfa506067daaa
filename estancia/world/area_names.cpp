// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/area_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/room_predictions.hpp"

namespace estancia {
namespace {

bool isSurelyRoom(const WorldArea& area) {
  return area.isSurelyRoom;
}

bool isNamedByRoom(const WorldArea& area) {
  return area.givenName.empty() && isSurelyRoom(area);
}

/// Whether an area's best room is more probable there than in any other area: a room that is said to occur
/// has to be somewhere.
bool isBest(const std::vector<std::vector<RoomProbability>>& pooled, std::size_t area) {
  const RoomProbability& best = pooled[area].front();
  return std::ranges::all_of(pooled, [&](const std::vector<RoomProbability>& other) {
    return std::ranges::none_of(other, [&](const RoomProbability& room) {
      return room.room == best.room && room.probability > best.probability;
    });
  });
}

bool holdsWords(const std::string& name, const std::string& words) {
  for (std::size_t from = 0; from < name.size(); from = name.find_first_not_of(' ', name.find(' ', from)))
    for (std::size_t to = name.find(' ', from);; to = name.find(' ', to + 1)) {
      if (sameWords(std::string_view(name).substr(from, to - from), words)) return true;
      if (to == std::string::npos || to - from > 2 * words.size() + 16) break;  // blanks and plurals
    }
  return false;
}

}  // namespace

void nameAreasByRooms(WorldMap& world) {
  if (!world.places.predictions) return;
  std::vector<std::size_t> areaOf;
  for (const int area : world.areaOfFrame)
    areaOf.push_back(area < 0 ? world.areas.size() : static_cast<std::size_t>(area));
  const RoomPredictions& predictions = *world.places.predictions;
  const auto pooled = poolRooms(predictions, areaOf, world.areas.size());
  std::map<std::string, int> areasOfRoom;
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    if (pooled[i].empty()) continue;
    WorldArea& area = world.areas[i];
    area.predictedRoom = printable(pooled[i].front().room);
    area.roomProbability = pooled[i].front().probability;
    area.isSurelyRoom =
        area.roomProbability > predictions.sureProbability() || (predictions.areListed && isBest(pooled, i));
    if (isSurelyRoom(area)) ++areasOfRoom[area.predictedRoom];
  }
  const auto isGiven = [&world](const std::string& name) {
    return std::ranges::any_of(world.areas,
                               [&](const WorldArea& area) { return sameWords(area.givenName, name); });
  };
  // People's names do not count, so that a number stays with its area when another one is named.
  std::map<std::string, int> number, spare = areasOfRoom;
  for (WorldArea& area : world.areas) {
    if (!isSurelyRoom(area)) continue;
    const std::string& room = area.predictedRoom;
    const bool alone = areasOfRoom[room] == 1;
    const int own = alone && isGiven(room) ? 2 : ++number[room];  // that area is the first one
    if (!isNamedByRoom(area)) continue;
    area.roomName = alone && own == 1 ? room : fmt::format("{} {}", room, own);
    while (isGiven(area.roomName)) area.roomName = fmt::format("{} {}", room, ++spare[room]);
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

std::vector<int> areasNamedPartly(const WorldMap& world, const std::string& text) {
  std::vector<int> areas;
  for (const WorldArea& area : world.areas)
    if (holdsWords(area.givenName, text) || holdsWords(area.roomName, text)) areas.push_back(area.id);
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
