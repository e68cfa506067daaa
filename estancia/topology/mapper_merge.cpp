// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/mapper_merge.hpp"

#include <algorithm>
#include <utility>

namespace estancia {
namespace {

constexpr double ratioTest = 0.8;

std::vector<float> meanOf(const NodeBank& bank, std::size_t slot) {
  return bank.compared(bank[slot].moments().mean());
}

/// How much nearer the two are than `of` is to the next one in the bank.
bool isNearest(const NodeBank& bank, std::span<const float> of, const NodeBank::Nearest& found) {
  const auto next = bank.nearest(of, found.slot);
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
    const std::vector<float> own = meanOf(b_, slot);
    const auto found = a_.nearest(own, a_.size());
    if (!found || found->distance >= join_) continue;
    const std::vector<float> other = meanOf(a_, found->slot);
    const auto back = b_.nearest(other, b_.size());
    if (back->slot != slot) continue;
    const bool isSure =
        found->distance < revisit_ && isNearest(a_, own, *found) && isNearest(b_, other, *back);
    links.push_back({a_[found->slot].id, b_[slot].id, found->distance, isSure ? revisit_ : join_, isSure});
  }
  return links;
}

std::optional<PlaceLink> PlaceLinker::between(int a, int b) const {
  const double distance = a_.distance(a_.slotOf(a), meanOf(b_, b_.slotOf(b)));
  return distance < join_ ? std::optional(PlaceLink{a, b, distance, join_}) : std::nullopt;
}

MapperMerge::MapperMerge(Mapper::Impl& merged) : merged_(merged) {
  merged_.estimateScales(false);
}

void MapperMerge::take(const Mapper::Impl& map, const Renumbering& now) {
  Mapper::Impl& to = merged_;
  const auto placeOf = [&now](int id) { return now.kept(id + now.firstNode); };
  for (std::size_t slot = 0; slot < map.bank.size(); ++slot) {
    NodeMemory node = map.bank[slot];
    const int own = node.id + now.firstNode, kept = placeOf(node.id);
    if (kept == own) {
      node.id = own;
      slots_[own] = to.bank.add(std::move(node));
    } else {
      to.bank.update(slots_.at(kept), [&node](NodeMemory& known) { known.merge(node); });
    }
    to.changes.changedNodes.insert(kept);
  }
  to.nextId = std::max(to.nextId, map.nextId + now.firstNode);
  for (const auto& [ends, transition] : map.transitions) {
    const int from = placeOf(ends.first), end = placeOf(ends.second);
    if (from == end) continue;
    const std::size_t first = now.frame(transition.firstFrame);
    Transition& known =
        to.transitions.try_emplace({from, end}, Transition{from, end, 0, first}).first->second;
    known.count += transition.count;
    to.changes.changedTransitions.insert({from, end});
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
  merged_.current = slots_.at(node);
  merged_.views.movePoses(pose);
}

}  // namespace estancia
