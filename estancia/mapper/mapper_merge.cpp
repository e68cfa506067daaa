// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/mapper_merge.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr double ratioTest = 0.8;

struct Match {
  std::size_t slot = 0;
  double distance = std::numeric_limits<double>::infinity();
  /// Nearest of the compared means of the searched place.
  std::vector<float> look = {};
};

/// The place of `bank` that looks most like one of another bank, in any of their modes.
Match nearestTo(const NodeBank& bank, const NodeBank& other, std::size_t slot, std::size_t except) {
  Match best;
  for (const Moments* look : other[slot].looks()) {
    std::vector<float> compared = other.compared(look->mean());
    const auto found = bank.nearest(compared, except);
    if (found && found->distance < best.distance) best = {found->slot, found->distance, std::move(compared)};
  }
  return best;
}

/// Whether it is the nearest one by far.
bool isFarthestAhead(const NodeBank& bank, const Match& found) {
  const auto next = bank.nearest(found.look, found.slot);
  return !next || found.distance < ratioTest * next->distance;
}

}  // namespace

PlaceLinker::PlaceLinker(Mapper::Impl& a, Mapper::Impl& b)
    : a_(a.bank),
      b_(b.bank),
      join_((a.thresholds.join + b.thresholds.join) / 2),
      revisit_((a.thresholds.revisit + b.thresholds.revisit) / 2) {
  if (!a.distance.standardized) return;
  Moments moments = a.scale.moments();
  moments.merge(b.scale.moments());
  const Standardization scale = standardizationBy(moments, a.prior);
  a.bank.setStandardization(scale);
  b.bank.setStandardization(scale);
}

std::vector<PlaceLink> PlaceLinker::nearest() const {
  std::vector<PlaceLink> links;
  for (std::size_t slot = 0; slot < b_.size(); ++slot) {
    const Match found = nearestTo(a_, b_, slot, a_.size());
    if (!(found.distance < join_)) continue;
    const Match back = nearestTo(b_, a_, found.slot, b_.size());
    if (back.slot != slot) continue;
    const bool isSure = found.distance < revisit_ && isFarthestAhead(a_, found) && isFarthestAhead(b_, back);
    links.push_back({a_[found.slot].id, b_[slot].id, found.distance, isSure ? revisit_ : join_, isSure});
  }
  return links;
}

std::optional<PlaceLink> PlaceLinker::between(int a, int b) const {
  double nearest = join_;
  for (const Moments* look : b_[b_.slotOf(b)].looks())
    nearest = std::min(nearest, a_.distance(a_.slotOf(a), b_.compared(look->mean())));
  return nearest < join_ ? std::optional(PlaceLink{a, b, nearest, join_}) : std::nullopt;
}

MapperMerge::MapperMerge(Mapper::Impl& merged) : merged_(merged) {
  merged_.estimateScales(false);
  merged_.hadOtherScales = true;
}

void MapperMerge::take(const Mapper::Impl& map, const Renumbering& now) {
  Mapper::Impl& to = merged_;
  const auto placeOf = [&now](int id) { return now.kept(id + now.firstNode); };
  for (std::size_t slot = 0; slot < map.bank.size(); ++slot) {
    NodeMemory node = map.bank[slot];
    const int kept = placeOf(node.id);
    if (const auto known = slots_.find(kept); known == slots_.end()) {
      node.id = kept;
      for (NodeBorder::Image& image : node.border.images) image.frame = now.frame(image.frame);
      slots_[kept] = to.bank.add(std::move(node));
    } else {
      to.bank.update(known->second, [&node](NodeMemory& place) { place.mergeOfOtherDrives(node); });
      to.bank.joinModes(known->second, to.thresholds.merge, 0);
    }
    to.changes.changedNodes.insert(kept);
  }
  to.nextId = std::max(to.nextId, map.nextId + now.firstNode);
  for (const auto& [ends, transition] : map.transitions) {
    const int from = placeOf(ends.first), end = placeOf(ends.second);
    if (from == end) continue;
    const std::size_t first = now.frame(transition.firstFrame);
    to.transition(from, end, first).count += transition.count;
  }
  if (!to.views.isOn()) return;
  for (PlaceView view : map.views.views()) {
    view.node = placeOf(view.node);
    for (std::size_t* frame : {&view.frame, &view.lastSeen}) *frame = now.frame(*frame);
    view.pose.reset();  // see finish()
    view.compared = to.bank.compared(view.embedded);
    to.views.keep(std::move(view), to.thresholds);
  }
}

void MapperMerge::finish(int node, const std::function<std::optional<Pose>(std::size_t)>& pose) {
  const auto last = slots_.find(node);
  if (last == slots_.end()) fail(ErrorCode::corruptFile, "a map lacks its last place, {}", node);
  merged_.current = last->second;
  merged_.firstOfDrive = merged_.nextId;
  merged_.endModes();
  merged_.views.movePoses(pose);
}

}  // namespace estancia
