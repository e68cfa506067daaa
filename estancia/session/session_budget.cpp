// How a mapping session keeps to its budget: what it must keep to go on, and what it holds in memory.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session.hpp"
#include "estancia/session/session_impl.hpp"

namespace estancia {
namespace {

/// Frames that a drive is guided by: with these a frame takes 1 to 2 ms.
constexpr std::uint64_t maxGuide = 4096;
/// Guide frames occupy the file with their labels and metadata, and the memory with twice their labels.
constexpr std::uint64_t guideShare = 4;  // share of the budgets: a quarter

}  // namespace

void MappingSession::Impl::setBudget(const MapBudget& wanted) {
  validate(wanted);
  mapper.setMemory(wanted.memory ? std::optional(*wanted.memory * megabyte) : std::nullopt);
  const std::optional<std::uint64_t> before = budget.file;
  budget = wanted;
  if (!budget.file)
    keeper.reset();
  else if (!keeper || budget.file != before)
    keeper.emplace(keeperOf(store, *budget.file));
  putBudget(store, budget);
}

void MappingSession::Impl::takeBudgetOf(const MapStore& other) {
  if (const MapBudget kept = budgetOf(other); kept != budget) setBudget(kept);
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
