// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/rooms_by_name.hpp"

#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/error.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"

namespace estancia {
namespace {

const WordGraph& getWordGraph() {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw Error(ErrorCode::missingDependency, wordNetHint());
  return *graph;
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
  if (installedWordGraph() == nullptr) return false;
  const TopologicalMap kept = readMap(map);
  if (kept.frames.empty() || (kept.predictions && !kept.predictions->areByName)) return false;
  const bool areListed = kept.predictions && kept.predictions->areListed;
  try {
    nameRoomsByNames(map, areListed ? kept.predictions->rooms : std::vector<std::string>());
  } catch (const Error& e) {
    if (e.code() != ErrorCode::unknownName) throw;
    return false;
  }
  return true;
}

}  // namespace estancia
