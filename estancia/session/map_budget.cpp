// Map budget: how it is kept in a map file, and how a file at rest is made to fit it.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/session.hpp"

#include <algorithm>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session_impl.hpp"

namespace estancia {
namespace {

constexpr const char* budgetKey = "budget";

}  // namespace

OptionGroup declare(MapBudget& budget) {
  OptionGroup group("budget", "How much memory and how large a file a map may take.");
  constexpr double most = 1e9;
  group.add("memory", &budget.memory, "Most memory for places, their views and what guides a drive.")
      .range(1, most)
      .unit("MB")
      .automatic("as much as they take")
      .why("Places that hold few images become parts of their neighbors, where they do not all fit.");
  group.add("file-budget", &budget.file, "Most bytes of the map file.")
      .range(1, most)
      .unit("MB")
      .automatic("as much as it takes")
      .why("The images that say least beside the others of their places are left out.");
  return group;
}

MapBudget budgetOf(const MapStore& store) {
  MapBudget kept;
  const auto bytes = store.findState(budgetKey);
  if (!bytes) return kept;
  ByteReader in(*bytes, "what the map says of its budget is damaged", "map the sequence again");
  for (std::optional<std::uint64_t>* bound : {&kept.memory, &kept.file})
    if (const auto value = in.number<std::uint64_t>(); value > 0) *bound = value;
  return kept;
}

void putBudget(MapStore& store, const MapBudget& budget) {
  ByteWriter out;
  out.number<std::uint64_t>(budget.memory.value_or(0));
  out.number<std::uint64_t>(budget.file.value_or(0));
  store.putState(budgetKey, out.bytes());
}

FrameKeeper keeperOf(MapStore& store, std::uint64_t megabytes) {
  FrameKeeper keeper(store, megabytes * megabyte);
  if (const auto sample = store.findState(frameSampleKey)) {
    ByteReader in(*sample, "what the map says of the frames that it keeps is damaged",
                  "map the sequence again");
    keeper.restore(in);
  }
  return keeper;
}

void fitFile(MapStore& store, const std::optional<std::uint64_t>& megabytes) {
  const std::optional<std::uint64_t> most = megabytes ? megabytes : budgetOf(store).file;
  if (!most) return;
  FrameKeeper keeper = keeperOf(store, *most);
  if (keeper.isFull()) {
    std::vector<std::size_t> needed = framesThatStay(store);
    restoreMapper(store).impl().addNeededFrames(needed);
    if (const auto known = store.findState(guideMapKey); known && !known->empty())
      DriveGuide::addNeededFrames(*known, store, needed);
    std::ranges::sort(needed);
    keeper.fit(needed);
    store.putState(frameSampleKey, keeper.state());
    store.commit();
  }
  // Frames that were written and then left out have made the file larger than its content.
  sqlite::Database& file = store.database();
  const auto bytes =
      static_cast<std::uint64_t>(file.number("PRAGMA page_count") * file.number("PRAGMA page_size"));
  if (bytes > *most * megabyte) store.compact();
}

CompactedMap compactMap(const std::filesystem::path& map, const std::optional<std::uint64_t>& fileBudget) {
  CompactedMap done;
  {
    MapStore store = MapStore::open(map, MapStore::Access::write);
    done.bytesBefore = std::filesystem::file_size(map);
    done.framesBefore = store.frameNumbers().size();
    if (fileBudget) fitFile(store, fileBudget);
    store.compact();
    done.framesAfter = store.frameNumbers().size();
  }
  done.bytesAfter = std::filesystem::file_size(map);
  return done;
}

void writeRoomPredictions(const RoomPredictions& predictions, const std::filesystem::path& path) {
  MapStore store = MapStore::open(path, MapStore::Access::write);
  store.putPredictions(predictions);
  store.commit();
  fitFile(store);
}

}  // namespace estancia
