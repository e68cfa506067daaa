// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/world_map.hpp"

#include <fstream>
#include <iterator>

#include "estancia/core/error.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world/leveling.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/world_store.hpp"
#include "fuzz/fuzz_target.hpp"
#include "fuzz/map_patches.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/sample_world.hpp"

namespace estancia::fuzz {

static std::string bytesOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

static std::string worldFile() {
  const std::filesystem::path file = fuzz::folder() / "whole.estancia";
  test::writeWorld(test::sampleWorld(), file);
  return bytesOf(file);
}

FUZZ_TARGET(world, map) {
  static const std::string whole = worldFile();
  const std::filesystem::path file = patchedMap(whole, bytes);
  const WorldMap world = readWorld(file);
  readObjectImage(file, 1);
  MapStore store = MapStore::open(file, MapStore::Access::read);
  const WorldStore layers(store, MapStore::Access::read);
  layers.forEachObservation([](std::size_t, const Observation&) { return true; });
  layers.views();
  layers.edits();
  layers.objectEdits();
}

/// Going on with a map of rooms reads what readWorld() does not.
FUZZ_TARGET(world, mapper) {
  static const test::FlatDrive drive;
  static const DescriptorSequence labeled = drive.labeled();
  constexpr std::size_t frames = 17;  // a room, and the first look into the next
  static const std::string whole = [] {
    const std::filesystem::path file = fuzz::folder() / "drive.estancia";
    test::mapUpTo(drive, labeled, frames, file);
    return bytesOf(file);
  }();
  const std::filesystem::path file = patchedMap(whole, bytes);
  test::mapUpTo(drive, labeled, frames + 1, file);
  readWorld(file);
}

FUZZ_TARGET(world, leveling) {
  Leveling().fromBytes(0, std::string(bytes));
}

}  // namespace estancia::fuzz
