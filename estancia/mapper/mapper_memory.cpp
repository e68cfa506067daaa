// Memory of a mapper: its limit, and the place that is merged when it is full.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

/// Memory of a place: moments of its probabilities and of its embedded descriptors, its row and its index.
/// Memory of a view: two vectors and its index entry. Measured by bench_mapper [bytes a label].
constexpr std::uint64_t nodeBytes = 25, viewBytes = 9;
/// Memory of a mode: its mean, its row and its index [bytes a label].
constexpr std::uint64_t modeBytes = 13;
/// Keyframes that thresholds are estimated from, one vector each.
constexpr std::uint64_t sampleBytes = 768 * sizeof(float);
constexpr std::uint64_t minNodes = 16;
/// A quarter of all is for the drive guide; another quarter of the rest without the sample is for views.
constexpr std::uint64_t viewsShare = 4;

}  // namespace

void Mapper::Impl::setMemory(const std::optional<std::uint64_t>& most) {
  if (!most) {
    maxNodes = std::numeric_limits<std::size_t>::max();
    if (views.isOn()) views.bound(options.views, thresholds);
    return;
  }
  const std::uint64_t bytes = *most;
  const std::uint64_t fixed = sampleBytes * labels, view = viewBytes * labels;
  // Two vectors of an image at either end of a place, for each of transitionImages.
  const std::uint64_t node = (nodeBytes + 4 * sizeof(float) * options.transitionImages) * labels;
  const std::uint64_t least = (fixed + minNodes * node * viewsShare / (viewsShare - 1)) * 4 / 3;
  if (bytes < least)
    fail(ErrorCode::tooLarge, "--memory {} MB is too small for {} labels; give at least {}",
         bytes / 1'000'000, labels, least / 1'000'000 + 1);
  const std::uint64_t free = bytes / 4 * 3 - fixed;
  maxNodes = free / node;
  if (!views.isOn()) return;
  const std::uint64_t maxViews = std::clamp<std::uint64_t>(free / viewsShare / view, 1, options.views);
  views.bound(maxViews, thresholds);
  maxNodes = (free - maxViews * view) / node;
}

std::size_t Mapper::Impl::neighborOf(std::size_t slot) const {
  const auto compared = bank.mean(slot);
  std::size_t nearest = slot;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](std::size_t other) {
    if (other == slot) return;
    const double away = bank.distance(other, compared);
    if (away < least) least = away, nearest = other;
  };
  for (const auto& [ends, transition] : transitions)
    if (ends.first == bank[slot].id || ends.second == bank[slot].id)
      consider(bank.slotOf(ends.first == bank[slot].id ? ends.second : ends.first));
  if (nearest != slot) return nearest;
  for (std::size_t other = 0; other < bank.size(); ++other)
    if (areOfOneSide(other, slot)) consider(other);
  return nearest;
}

bool Mapper::Impl::areOfOneSide(std::size_t slot, std::size_t other) const {
  return !lost || lost->isOwn(bank[slot].id) == lost->isOwn(bank[other].id);
}

bool Mapper::Impl::isFull() const {
  return bank.size() + (bank.rows() - bank.size()) * modeBytes / nodeBytes >= maxNodes;
}

void Mapper::Impl::makeRoom(std::size_t frame) {
  forgetModes();
  if (!isFull()) return;
  std::size_t spared = bank.size(), own = 0;
  std::uint64_t all = 0;
  for (std::size_t slot = 0; slot < bank.size() && lost; ++slot) own += lost->isOwn(bank[slot].id) ? 1 : 0;
  for (std::size_t slot = 0; slot < bank.size(); ++slot) {
    all += bank[slot].frames;
    if (slot == current || bank[slot].id == lostNode) continue;
    if (lost && (lost->isOwn(bank[slot].id) ? own : bank.size() - own) < 2) continue;  // no neighbor
    if (spared == bank.size() ||
        std::pair(bank[slot].frames, bank[slot].id) < std::pair(bank[spared].frames, bank[spared].id))
      spared = slot;
  }
  // A place with a quarter of the mean number of images is a place that the robot uses.
  if (spared == bank.size() || bank[spared].frames * 4 * bank.size() > all)
    fail(ErrorCode::tooLarge,
         "the {} places of the map fill the memory that they may take, and the robot uses all of them; go on "
         "with more (estancia map --continue --memory …)",
         bank.size());
  const std::size_t kept = neighborOf(spared);
  // Beyond any threshold: it is not the same place, but no place is left for it.
  merge(kept, spared,
        {frame, bank[kept].id, bank[spared].id, bank.distance(kept, bank.mean(spared)),
         std::numeric_limits<double>::infinity()});
}

const Decision& Mapper::Impl::lastDecision() const {
  const auto last =
      std::ranges::find_if(changes.events.rbegin(), changes.events.rend(),
                           [](const auto& event) { return std::holds_alternative<Decision>(event); });
  return std::get<Decision>(*last);
}

void Mapper::Impl::addNeededFrames(std::vector<std::size_t>& frames) const {
  views.addNeededFrames(frames);
  const ThresholdEstimator::Memory memory = scale.memory();
  for (const auto& entry : memory.sampled) frames.push_back(entry.second);
  if (memory.frames == 0) return;
  frames.push_back(memory.lastView);
  frames.push_back(memory.frames - 1);
  for (std::size_t frame = 0; isWarmingUp() && frame + 1 < memory.frames; ++frame) frames.push_back(frame);
  for (std::size_t slot = 0; slot < bank.size(); ++slot)
    for (const NodeBorder::Image& image : bank[slot].border.images) frames.push_back(image.frame);
}

}  // namespace estancia
