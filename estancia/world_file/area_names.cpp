// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/area_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/room_predictions.hpp"

namespace estancia {
namespace {

bool isNamedByRoom(const WorldArea& area) {
  return area.givenName.empty() && area.isSurelyRoom;
}

using PooledRooms = std::vector<std::vector<RoomProbability>>;  // rooms of each area, best first

/// A room that is known to occur has to be somewhere: rooms that no area surely is, one to one to areas that
/// surely are none, the most probable pair first; "" for an area that is sure or left over, or where what is
/// left is no more probable than by chance.
std::vector<std::string> assignRooms(const PooledRooms& pooled, const RoomPredictions& predictions) {
  const double chance = 1 / static_cast<double>(predictions.rooms.size());
  struct Candidate {
    std::size_t area = 0;
    const RoomProbability* room = nullptr;
  };
  std::vector<Candidate> candidates;
  std::set<std::string> taken;
  for (std::size_t area = 0; area < pooled.size(); ++area) {
    if (!pooled[area].empty() && pooled[area].front().probability > predictions.sureProbability())
      taken.insert(pooled[area].front().room);
    else
      for (const RoomProbability& room : pooled[area])
        if (room.probability > chance) candidates.push_back({area, &room});
  }
  std::ranges::stable_sort(candidates, std::greater(),
                           [](const Candidate& candidate) { return candidate.room->probability; });
  std::vector<std::string> assigned(pooled.size());
  for (const Candidate& candidate : candidates)
    if (assigned[candidate.area].empty() && taken.insert(candidate.room->room).second)
      assigned[candidate.area] = candidate.room->room;
  return assigned;
}

/// Sets what the area is predicted to be: its best room, or the one that it has to be.
void predictRoom(WorldArea& area, const std::vector<RoomProbability>& rooms, const std::string& assigned,
                 bool isSure) {
  const RoomProbability* room = &rooms.front();
  if (!assigned.empty()) room = &*std::ranges::find(rooms, assigned, &RoomProbability::room);
  area.isSurelyRoom = isSure || !assigned.empty();
  area.predictedRoom = printable(room->room);
  area.roomProbability = room->probability;
}

bool holdsWords(const std::string& name, const std::string& words) {
  for (std::size_t from = 0; from < name.size(); from = name.find_first_not_of(' ', name.find(' ', from)))
    for (std::size_t to = name.find(' ', from);; to = name.find(' ', to + 1)) {
      if (sameWords(std::string_view(name).substr(from, to - from), words)) return true;
      if (to == std::string::npos || to - from > 2 * words.size() + 16) break;  // blanks and plurals
    }
  return false;
}

template <class Is>
std::vector<int> areasWhere(const WorldMap& world, const Is& is) {
  std::vector<int> areas;
  for (const WorldArea& area : world.areas)
    if (is(area)) areas.push_back(area.id);
  return areas;
}

}  // namespace

void nameAreasByRooms(WorldMap& world) {
  if (world.places.predictions) nameAreasByRooms(world, *world.places.predictions, world.areaOfFrame);
}

void nameAreasByRooms(WorldMap& world, const RoomPredictions& predictions, std::span<const int> areaOfRow) {
  for (WorldArea& area : world.areas) {
    area.predictedRoom = area.roomName = "";
    area.roomProbability = 0;
    area.isSurelyRoom = false;
  }
  std::vector<std::size_t> areaOf;
  for (const int area : areaOfRow)
    areaOf.push_back(area < 0 ? world.areas.size() : static_cast<std::size_t>(area));
  const auto pooled = poolRooms(predictions, areaOf, world.areas.size());
  const std::vector<bool> sure = areSureRooms(predictions, areaOf, pooled, GroupedBy::space);
  const auto assigned =
      predictions.areListed ? assignRooms(pooled, predictions) : std::vector<std::string>(pooled.size());
  std::map<std::string, int> areasOfRoom;
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    if (pooled[i].empty()) continue;
    WorldArea& area = world.areas[i];
    predictRoom(area, pooled[i], assigned[i], sure[i]);
    if (area.isSurelyRoom) ++areasOfRoom[area.predictedRoom];
  }
  const auto isGiven = [&world](const std::string& name) {
    return std::ranges::any_of(world.areas,
                               [&](const WorldArea& area) { return sameWords(area.givenName, name); });
  };
  // People's names do not count, so that a number stays with its area when another one is named.
  std::map<std::string, int> number, spare = areasOfRoom;
  for (WorldArea& area : world.areas) {
    if (!area.isSurelyRoom) continue;
    const std::string& room = area.predictedRoom;
    const bool alone = areasOfRoom[room] == 1;
    const int own = alone && isGiven(room) ? 2 : ++number[room];  // the first one is that area
    if (!isNamedByRoom(area)) continue;
    area.roomName = alone && own == 1 ? room : fmt::format("{} {}", room, own);
    while (isGiven(area.roomName)) area.roomName = fmt::format("{} {}", room, ++spare[room]);
  }
}

std::vector<int> areasNamed(const WorldMap& world, const std::string& text) {
  for (const std::string WorldArea::*name : {&WorldArea::givenName, &WorldArea::roomName}) {
    auto areas = areasWhere(world, [&](const WorldArea& area) { return sameWords(area.*name, text); });
    if (!areas.empty()) return areas;
  }
  return areasWhere(world, [&](const WorldArea& area) {
    return isNamedByRoom(area) && sameWords(area.predictedRoom, text);
  });
}

std::vector<int> areasNamedPartly(const WorldMap& world, const std::string& text) {
  return areasWhere(world, [&](const WorldArea& area) {
    return holdsWords(area.givenName, text) || holdsWords(area.roomName, text);
  });
}

std::vector<int> areasCalled(const WorldMap& world, const std::string& text) {
  std::vector<int> areas = areasNamed(world, text);
  if (!areas.empty()) return areas;
  return areasWhere(world, [&](const WorldArea& area) { return sameWords(area.name, text); });
}

}  // namespace estancia
