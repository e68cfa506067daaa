// A drive that may be in another building: what keeps it apart from the places of the map.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <utility>

#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/mapper/mapper_merge.hpp"
#include "estancia/stats/compared_vectors.hpp"

namespace estancia {

void Mapper::Impl::getLost() {
  lost.reset();
  firstOfDrive = nextId;
  if (!distance.standardized) return;
  const double tauJoin = options.tauJoin ? scale.initial().join : thresholds.join;
  lost.emplace(scale.moments(), tauJoin, scale.frames(), nextId);
}

bool Mapper::Impl::mayBeOne(int a, int b) const {
  if (lost) return lost->isOwn(a) && lost->isOwn(b);
  return !hadOtherScales || std::max(a, b) >= firstOfDrive;
}

std::optional<std::span<const float>> Mapper::Impl::nearestKnown(const PlaceView& seen) const {
  if (views.isOn()) return views.nearestOfEarlierDrives(seen.compared);
  std::optional<std::span<const float>> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t slot = 0; slot < bank.size(); ++slot) {
    if (lost->isOwn(bank[slot].id)) continue;
    const double away = bank.distance(slot, seen.compared);
    if (away >= least) continue;
    least = away;
    nearest = bank[slot].moments().mean();
  }
  return nearest;
}

/// While the drive is lost, matches to places of the map are ignored.
void Mapper::Impl::stayLost(const PlaceView& seen, Decision& decision) {
  if (const auto known = lost->isDue() ? nearestKnown(seen) : std::nullopt) {
    const Standardization common = lost->scale(prior);
    lost->count(decision.frame, compare(distance.comparison, comparedVector(distance, common, *known),
                                        comparedVector(distance, common, seen.embedded)));
  }
  if (decision.kind != DecisionKind::localize && decision.kind != DecisionKind::revisit) return;
  if (lost->isOwn(decision.other)) return;
  if (lost->isRecognized() && !lost->cameFromElsewhere()) return lost.reset();
  isBack = lost->cameFromElsewhere();
  const bool stays =
      current && decision.toCurrent < thresholds.join && !views.isElsewhere(decision.current, seen.pose);
  decision.kind = stays ? DecisionKind::join : current ? DecisionKind::createNode : DecisionKind::start;
  decision.other = -1;
  decision.toOther = std::numeric_limits<double>::quiet_NaN();
}

void Mapper::Impl::takeAlone(const Impl& alone, const std::function<std::size_t(std::size_t)>& number,
                             const std::function<std::optional<Pose>(std::size_t)>& pose) {
  const int firstNode = lost->firstNode();
  const bool wasNowhereElse = lostNode && alone.bank.size() == 1;
  for (std::size_t slot = bank.size(); slot-- > 0;)
    if (lost->isOwn(bank[slot].id)) bank.remove(slot);
  views.forgetFrom(firstNode);
  std::erase_if(transitions, [this](const auto& entry) {
    return lost->isOwn(entry.first.first) || lost->isOwn(entry.first.second);
  });
  std::erase_if(absorbedBy, [this](const auto& entry) { return lost->isOwn(entry.second); });
  lostNode.reset();
  current.reset();
  nextId = firstNode;
  hadOtherScales = true;

  for (auto event : alone.changes.events) {
    if (auto* merged = std::get_if<Merge>(&event)) {
      merged->frame = number(merged->frame);
      for (int* node : {&merged->kept, &merged->absorbed}) *node += firstNode;
    } else {
      auto& decision = std::get<Decision>(event);
      decision.frame = number(decision.frame);
      for (int* node : {&decision.node, &decision.current, &decision.other})
        if (*node >= 0) *node += firstNode;
    }
    changes.events.push_back(event);
  }
  MapperMerge merge(*this);
  merge.take(alone, {firstNode, number, [](int id) { return id; }});
  merge.finish(alone.currentNode() + firstNode, pose);
  // if the drive was nowhere else, it goes on as if it had never been lost
  if (wasNowhereElse) lostNode = currentNode();
  stay = 0;
  recent.clear();
  firstOfDrive = nextId;
  lost->noteMapped(scale.frames());
}

bool Mapper::Impl::hasRoomFor(const Impl& alone) const {
  std::size_t others = 0;
  for (std::size_t slot = 0; slot < bank.size(); ++slot)
    if (!lost->isOwn(bank[slot].id)) ++others;
  return others + alone.bank.size() <= maxNodes;
}

}  // namespace estancia
