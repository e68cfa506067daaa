// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/rooms_by_name.hpp"

#include <optional>
#include <utility>

#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/topology/store.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/world/area_names.hpp"

namespace estancia {
namespace {

const WordGraph& getWordGraph() {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw Error(ErrorCode::missingDependency, wordNetHint());
  return *graph;
}

/// Whether a map that was made or continued is to have rooms by names.
bool isNamedByNames(const TopologicalMap& map) {
  return installedWordGraph() != nullptr && !map.frames.empty() &&
         (!map.predictions || map.predictions->areByName);
}

std::vector<std::string> roomsListedIn(const TopologicalMap& map) {
  return map.predictions && map.predictions->areListed ? map.predictions->rooms : std::vector<std::string>();
}

}  // namespace

void requireRoomNames(const std::vector<std::string>& rooms) {
  const Vocabulary any({"thing"});
  predictRoomsByNames(getWordGraph(), any, DescriptorMatrix(any.size()), listedRooms(rooms));
}

void nameRoomsByNames(const std::filesystem::path& map, const std::vector<std::string>& rooms) {
  const WordGraph& graph = getWordGraph();
  const DescriptorSequence labels = readMapDescriptors(map);
  writeRoomPredictions(predictRoomsByNames(graph, labels.vocabulary, labels.descriptors, listedRooms(rooms)),
                       map);
}

bool renewRoomsByNames(const std::filesystem::path& map) {
  const TopologicalMap kept = readMap(map);
  if (!isNamedByNames(kept)) return false;
  try {
    nameRoomsByNames(map, roomsListedIn(kept));
  } catch (const Error& e) {
    if (e.code() != ErrorCode::unknownName) throw;
    return false;
  }
  return true;
}

/// Of the last vocabulary; nothing where WordNet lacks the rooms.
struct GrowingRooms::Known {
  std::string vocabulary;  // its digest
  std::vector<std::string> listed;
  std::optional<RoomsByNames> rooms;
};

GrowingRooms::GrowingRooms() = default;
GrowingRooms::~GrowingRooms() = default;

void GrowingRooms::name(const std::filesystem::path& map, WorldMap& world) {
  constexpr std::size_t enough = 1000;
  if (world.areas.empty() || !isNamedByNames(world.places)) return;
  const Vocabulary& vocabulary = world.places.vocabulary;
  std::vector<std::string> listed = listedRooms(roomsListedIn(world.places));
  if (!known_ || known_->vocabulary != vocabulary.digest() || known_->listed != listed) {
    known_ = std::make_unique<Known>(Known{vocabulary.digest(), std::move(listed), {}});
    try {
      known_->rooms.emplace(getWordGraph(), vocabulary, known_->listed);
    } catch (const Error& e) {
      if (e.code() != ErrorCode::unknownName) throw;
    }
  }
  if (!known_->rooms) return;
  const std::size_t frames = world.places.frames.size(), step = (frames + enough - 1) / enough;
  const MapStore store = MapStore::open(map, MapStore::Access::read);
  DescriptorMatrix images(vocabulary.size());
  std::vector<int> areas;
  for (std::size_t i = 0; i < frames; i += step) {
    images.append(store.descriptor(i * world.places.stride));
    areas.push_back(world.areaOfFrame[i]);
  }
  nameAreasByRooms(world, known_->rooms->predict(images), areas);
}

}  // namespace estancia
