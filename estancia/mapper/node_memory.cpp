// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_memory.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace estancia {

namespace {

Moments meanOf(const Moments& moments) {
  Moments mean(moments.mean().size(), false);
  mean.merge(moments);
  return mean;
}

}  // namespace

std::vector<const Moments*> NodeMemory::looks() const {
  std::vector<const Moments*> looks{&moments()};
  for (const Moments& mode : modes) looks.push_back(&mode);
  return looks;
}

void NodeMemory::merge(const NodeMemory& other) {
  if (!modes.empty() || !other.modes.empty()) {
    const std::vector<Moments> its = other.modesOfEarlierDrives();
    modes = modesOfEarlierDrives();
    modes.insert(modes.end(), its.begin(), its.end());
  }
  if (!own)
    own = other.own;
  else if (other.own)
    own->merge(*other.own);
  frames += other.frames;
  probabilities.merge(other.probabilities);
  if (embedded) embedded->merge(*other.embedded);
  setNextMergeCheck();
}

void NodeMemory::mergeOfOtherDrives(const NodeMemory& other) {
  NodeMemory its = other;
  for (NodeMemory* node : {this, &its}) {
    node->modes = node->modesOfEarlierDrives();
    if (node->own) node->modes.push_back(std::move(*node->own));
    node->own.reset();
  }
  merge(its);
}

std::vector<Moments> NodeMemory::modesOfEarlierDrives() const {
  if (!modes.empty()) return modes;
  Moments before = meanOf(moments());
  if (own) before.remove(*own);
  return before.weight() > 0 ? std::vector<Moments>{std::move(before)} : std::vector<Moments>();
}

void NodeMemory::endDrive(double threshold, std::uint64_t fewest, const Distance& distance) {
  if (own) {
    modes = modesOfEarlierDrives();
    modes.push_back(std::move(*own));
    own.reset();
  }
  joinModes(threshold, fewest, distance);
  if (modes.size() == 1) modes.clear();  // the mean of all frames is the same
}

void NodeMemory::joinModes(double threshold, std::uint64_t fewest, const Distance& distance) {
  while (modes.size() > 1) {
    std::size_t kept = 0, gone = 1;
    // The means of few frames are joined first.
    std::pair nearest(true, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < modes.size(); ++i)
      for (std::size_t j = i + 1; j < modes.size(); ++j) {
        const bool areMany = std::min(modes[i].weight(), modes[j].weight()) >= static_cast<double>(fewest);
        const std::pair found(areMany, distance(modes[i], modes[j]));
        if (found >= nearest) continue;
        nearest = found;
        kept = i;
        gone = j;
      }
    if (nearest.first && nearest.second >= threshold && modes.size() <= maxModes) return;
    modes[kept].merge(modes[gone]);
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(gone));
  }
}

void NodeMemory::setNextMergeCheck() {
  nextMergeCheck = frames + std::max<std::uint64_t>(1, frames / 4);
}

}  // namespace estancia
