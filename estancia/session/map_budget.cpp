// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/session/session_impl.hpp"

namespace estancia {
namespace {

constexpr const char* budgetKey = "budget";

/// Frames that a drive is guided by: with these a frame takes 1 to 2 ms.
constexpr std::uint64_t maxGuide = 4096;
/// Guide frames occupy the file with their labels and metadata, and the memory with twice their labels.
constexpr std::uint64_t guideShare = 4;  // share of the budgets: a quarter

/// Keeps the file within so many megabytes, with what it has kept so far. The store must outlive it.
FrameKeeper keeperOf(MapStore& store, std::uint64_t megabytes) {
  FrameKeeper keeper(store, megabytes * megabyte);
  if (const auto sample = store.findState(frameSampleKey)) {
    ByteReader in(*sample, "what the map says of the frames that it keeps is damaged",
                  "map the sequence again");
    keeper.restore(in);
  }
  return keeper;
}

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

void MappingSession::Impl::setBudget(const MapBudget& wanted) {
  validate(wanted);
  mapper.setMemory(wanted.memory ? std::optional(*wanted.memory * megabyte) : std::nullopt);
  const std::optional<std::uint64_t> before = budget.file;
  budget = wanted;
  if (!budget.file)
    keeper.reset();
  else if (!keeper || budget.file != before)
    keeper.emplace(keeperOf(store, *budget.file));
  ByteWriter out;
  for (const auto& bound : {budget.memory, budget.file}) out.number<std::uint64_t>(bound.value_or(0));
  store.putState(budgetKey, out.bytes());
}

std::size_t MappingSession::Impl::maxGuideFrames() const {
  const std::uint64_t words = store.identity().vocabulary.size() * sizeof(float);
  std::uint64_t most = maxGuide;
  if (budget.file)
    most = std::min(most, *budget.file * megabyte / guideShare / (words + FrameKeeper::rowBytes));
  if (budget.memory) most = std::min(most, *budget.memory * megabyte / guideShare / (2 * words));
  return std::max<std::uint64_t>(1, most);
}

std::vector<std::size_t> MappingSession::Impl::neededFrames() {
  std::vector<std::size_t> frames = framesThatStay(store);
  mapper.impl().addNeededFrames(frames);
  if (guide) guide->addNeededFrames(frames);
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

void MappingSession::Impl::settleWaiting(const std::vector<std::size_t>& needed) {
  for (const FrameKeeper::Waiting& waiting : keeper->takeNeeded(needed))
    keep(waiting.frame, waiting.descriptor, waiting.given);
}

}  // namespace estancia
