// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/rooms_by_name.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/error.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/session/session.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/world_file/area_names.hpp"

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

/// Expands predictions of each `stride`-th frame to all `frames`; the others have none.
RoomPredictions spread(RoomPredictions predictions, std::size_t stride, std::size_t frames) {
  if (stride == 1) return predictions;
  DescriptorMatrix all(predictions.rooms.size());
  all.reserve(frames);
  const std::vector<float> none(predictions.rooms.size(), 0);
  for (std::size_t i = 0; i < frames; ++i)
    all.append(i % stride == 0 ? predictions.probabilities.row(i / stride) : DescriptorView(none));
  predictions.probabilities = std::move(all);
  for (RoomEvidence& told : predictions.evidence) told.image *= stride;
  return predictions;
}

}  // namespace

void requireRoomNames(const std::vector<std::string>& rooms) {
  const Vocabulary any({"thing"});
  predictRoomsByNames(getWordGraph(), any, DescriptorMatrix(any.size()), listedRooms(rooms));
}

void nameRoomsByNames(const std::filesystem::path& map, const std::vector<std::string>& rooms,
                      std::size_t maxFrames) {
  const WordGraph& graph = getWordGraph();
  const MapStore store = MapStore::open(map, MapStore::Access::read);
  const std::vector<std::size_t> numbers = store.frameNumbers();
  const std::size_t frames = numbers.size();
  const std::size_t stride = std::max<std::size_t>(1, (frames + maxFrames - 1) / maxFrames);
  const Vocabulary& vocabulary = store.identity().vocabulary;
  DescriptorMatrix images(vocabulary.size());
  images.reserve((frames + stride - 1) / stride);
  for (std::size_t i = 0; i < frames; i += stride) images.append(store.descriptor(numbers[i]));
  writeRoomPredictions(
      spread(predictRoomsByNames(graph, vocabulary, images, listedRooms(rooms)), stride, frames), map);
}

bool renewRoomsByNames(const std::filesystem::path& map) {
  const TopologicalMap kept = MapStore::open(map, MapStore::Access::read).load(maxFramesOfAnswers);
  if (!isNamedByNames(kept)) return false;
  try {
    nameRoomsByNames(map, roomsListedIn(kept));
  } catch (const Error& e) {
    if (e.code() != ErrorCode::unknownName) throw;
    return false;
  }
  return true;
}

/// Cache for the last vocabulary; empty where WordNet lacks the rooms.
struct GrowingRooms::Known {
  std::string vocabulary;  // its digest
  std::vector<std::string> listed;
  std::optional<RoomsByNames> rooms;
};

void GrowingRooms::name(const std::filesystem::path& map, WorldMap& world) {
  constexpr std::size_t enough = 1000;
  if (world.areas.empty() || !isNamedByNames(world.places)) return;
  const Vocabulary& vocabulary = world.places.vocabulary;
  std::vector<std::string> listed = listedRooms(roomsListedIn(world.places));
  if (!known_ || known_->vocabulary != vocabulary.digest() || known_->listed != listed) {
    known_ = std::make_shared<Known>(Known{vocabulary.digest(), std::move(listed), {}});
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
    images.append(store.descriptor(world.places.frames[i].number));
    areas.push_back(world.areaOfFrame[i]);
  }
  nameAreasByRooms(world, known_->rooms->predict(images), areas);
}

}  // namespace estancia
