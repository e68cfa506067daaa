// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {
namespace {

/// A thing that is seen from more sides grows, but it stays a mug.
constexpr double maxGrowth = 4;                         // growth of its volume
constexpr double shortestReach = 0.2, thinnest = 0.02;  // [m]

double volumeOf(const cv::Point3d& size) {
  return std::max(thinnest, size.x) * std::max(thinnest, size.y) * std::max(thinnest, size.z);
}

std::string numbered(const WorldObject& object) {
  return fmt::format("{} ({})", object.id, object.displayName());
}

void correctObjects(const std::filesystem::path& map, const ObjectEdit& edit) {
  MapStore store = MapStore::open(map, MapStore::Access::write);
  putObjectEdit(store, edit);
  store.commit();
}

}  // namespace

int objectOf(const ObjectEdit& edit, std::span<const WorldObject> objects) {
  const cv::Point3d& size = edit.size;
  double nearest = std::max(shortestReach, std::max({size.x, size.y, size.z}) / 2);
  int found = -1;
  for (const WorldObject& object : objects) {
    const double growth = volumeOf(object.size) / volumeOf(size);
    if (growth > maxGrowth || growth < 1 / maxGrowth) continue;
    if (const double distance = cv::norm(object.center - edit.center); distance <= nearest) {
      nearest = distance;
      found = object.id;
    }
  }
  return found;
}

std::vector<int> applyEdits(std::span<const ObjectEdit> edits, std::vector<WorldObject>& objects) {
  std::vector<bool> removed(objects.size());
  for (const ObjectEdit& edit : edits) {
    const int found = objectOf(edit, objects);
    if (found < 0) continue;
    if (edit.kind == ObjectEdit::Kind::name)
      objects[static_cast<std::size_t>(found)].givenName = edit.name;
    else
      removed[static_cast<std::size_t>(found)] = true;
  }
  std::vector<int> numbers(objects.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (!removed[i]) numbers[i] = next++;
  std::erase_if(objects,
                [&](const WorldObject& object) { return removed[static_cast<std::size_t>(object.id)]; });
  for (WorldObject& object : objects) {
    object.id = numbers[static_cast<std::size_t>(object.id)];
    if (object.onObject < 0) continue;
    object.onObject = numbers[static_cast<std::size_t>(object.onObject)];
    if (object.onObject < 0) object.support = Support::surface;
  }
  return numbers;
}

const WorldObject& getObject(const WorldMap& world, const std::string& object) {
  if (world.objects.empty())
    fail(ErrorCode::insufficientData,
         "the map has no objects; map a drive with depth (`estancia check` tells what is missing)");
  if (const WorldObject* found = world.findObject(numberIn(object))) return *found;
  std::vector<std::string> called;
  const WorldObject* last = nullptr;
  for (const WorldObject& candidate : world.objects)
    if (candidate.displayName() == object) {
      called.push_back(numbered(candidate));
      last = &candidate;
    }
  if (called.size() == 1) return *last;
  if (!called.empty())
    fail(ErrorCode::unknownName, "the map has several objects \"{}\": {}; give the number of one",
         printable(object), fmt::join(called, ", "));
  fail(ErrorCode::unknownName, "the map has no object \"{}\"; it has the numbers 0 to {}", printable(object),
       world.objects.size() - 1);
}

ObjectEdit namingOf(const WorldObject& object, const std::string& name) {
  requireGivenName(name, "an object");
  return {ObjectEdit::Kind::name, object.center, object.size, name};
}

ObjectEdit removalOf(const WorldObject& object) {
  return {ObjectEdit::Kind::remove, object.center, object.size, ""};
}

void nameObject(const std::filesystem::path& map, const std::string& object, const std::string& name) {
  correctObjects(map, namingOf(getObject(readWorld(map), object), name));
}

void deleteObject(const std::filesystem::path& map, const std::string& object) {
  correctObjects(map, removalOf(getObject(readWorld(map), object)));
}

void putObjectEdit(MapStore& store, const ObjectEdit& edit) {
  WorldStore layers(store, MapStore::Access::write);
  KnownStore recognized(store);
  WorldMap world{store.load()};
  layers.read(world);
  recognized.read(world);
  std::map<SegmentPlace, int> segments = layers.objectSegments();
  std::vector<std::optional<KnownPose>> known;
  const std::vector<int> numbers = applyEdits(std::span(&edit, 1), world.objects);
  for (const WorldObject& object : world.objects) known.push_back(object.known);
  for (auto& [place, object] : segments) object = numbers[static_cast<std::size_t>(object)];
  std::erase_if(segments, [](const auto& segment) { return segment.second < 0; });
  layers.addObjectEdit(edit);
  layers.putObjects(world.objects, segments);
  recognized.putPoses(known);
}

}  // namespace estancia
