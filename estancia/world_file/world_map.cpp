// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/world_map.hpp"

#include <map>

#include "estancia/core/label_words.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

int WorldMap::areaOfNode(int node) const {
  std::map<int, std::size_t> frames;
  for (std::size_t i = 0; i < places.frames.size(); ++i)
    if (places.frames[i].node == node && areaOfFrame[i] >= 0) ++frames[areaOfFrame[i]];
  int most = -1;
  for (const auto& [area, count] : frames)
    if (most < 0 || count > frames[most]) most = area;
  return most;
}

const WorldArea* WorldMap::findArea(int id) const {
  return id >= 0 && id < static_cast<int>(areas.size()) ? &areas[static_cast<std::size_t>(id)] : nullptr;
}

const WorldObject* WorldMap::findObject(int id) const {
  return id >= 0 && id < static_cast<int>(objects.size()) ? &objects[static_cast<std::size_t>(id)] : nullptr;
}

std::string WorldObject::displayName() const {
  return !givenName.empty() ? givenName
         : known            ? known->name
         : words.empty()    ? "object"
                            : shortLabel(words.front().label);
}

Floor floorOf(const WorldMap& world) {
  if (world.plan) return world.plan->floor;
  std::vector<Pose> poses;
  for (const MappedFrame& frame : world.places.frames)
    if (frame.pose && frame.pose->isPlausible()) poses.push_back(*frame.pose);
  return Floor(poses);
}

WorldMap readWorld(const std::filesystem::path& path, std::size_t maxFrames) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  store.beginReading();
  const WorldStore layers(store, MapStore::Access::read);
  std::vector<std::size_t> named;
  if (maxFrames < store.frameCount()) {
    named = store.namedFrames();
    for (const std::size_t frame : layers.objectFrames()) named.push_back(frame);
  }
  WorldMap world{store.load(maxFrames, named)};
  layers.read(world);
  KnownStore(store).read(world);
  store.endReading();
  return world;
}

std::vector<unsigned char> readObjectImage(const std::filesystem::path& path, int object) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  return WorldStore(store, MapStore::Access::read).objectImage(object);
}

std::vector<unsigned char> readPlaceImage(const std::filesystem::path& path, const WorldMap& world,
                                          int node) {
  const TopologicalMap& map = world.places;
  const MapStore store = MapStore::open(path, MapStore::Access::read);
  std::vector<std::size_t> frames;
  for (const std::size_t frame : store.imageFrames())
    if (!map.frames.empty() && map.frames[map.indexOf(frame)].node == node) frames.push_back(frame);
  return frames.empty() ? std::vector<unsigned char>() : store.image(frames[frames.size() / 2]);
}

}  // namespace estancia
