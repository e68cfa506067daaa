// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/mapper/mapper_merge.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia {
namespace {

/// Keyframes: as many as a robot takes in a room. A kitchen resembles another building's.
constexpr std::size_t maxCounted = 100;

}  // namespace

LostDrive::LostDrive(Moments map, double tauJoin, std::size_t firstFrame, int firstNode)
    : map_(std::move(map)),
      drive_(map_.mean().size(), true),
      tauJoin_(tauJoin),
      firstFrame_(firstFrame),
      firstNode_(firstNode) {}

void LostDrive::add(std::span<const float> embedded) {
  drive_.add(embedded);
  isDue_ = true;
}

void LostDrive::count(std::size_t frame, double away) {
  isDue_ = false;
  last_.push_back({frame, away < tauJoin_});
  ++(last_.back().isAlike ? alike_ : unlike_);
  if (last_.size() > maxCounted) last_.pop_front();
}

bool LostDrive::isRecognized() const {
  return 2 * std::ranges::count(last_, true, &Keyframe::isAlike) > std::ssize(last_);
}

std::size_t LostDrive::cameBack() const {
  std::size_t frame = firstFrame_;
  int ahead = 0, most = 0;  // balance of keyframes that resemble it
  for (auto keyframe = last_.rbegin(); keyframe != last_.rend(); ++keyframe) {
    ahead += keyframe->isAlike ? 1 : -1;
    if (ahead <= most) continue;
    most = ahead;
    frame = keyframe->frame;
  }
  return frame;
}

std::string LostDrive::toBytes() const {
  ByteWriter out;
  out.number(tauJoin_);
  out.number<std::uint64_t>(firstFrame_);
  out.number<std::int32_t>(firstNode_);
  for (const std::size_t count : {alike_, unlike_, mapped_}) out.number<std::uint64_t>(count);
  out.number<std::uint64_t>(last_.size());
  for (const Keyframe& keyframe : last_) {
    out.number<std::uint64_t>(keyframe.frame);
    out.number<std::uint8_t>(keyframe.isAlike ? 1 : 0);
  }
  for (const Moments* moments : {&map_, &drive_}) out.raw(moments->toBytes());
  return out.bytes();
}

LostDrive LostDrive::from(ByteReader& in, std::size_t labels, std::size_t frames, int nodes) {
  const auto tauJoin = in.number<double>();
  const auto firstFrame = in.number<std::uint64_t>();
  const auto firstNode = in.number<std::int32_t>();
  std::array<std::size_t, 3> counts{};
  for (std::size_t& count : counts) count = in.number<std::uint64_t>();
  std::deque<Keyframe> last;
  bool areTrue = firstFrame <= frames && firstNode >= 0 && firstNode <= nodes && std::isfinite(tauJoin);
  for (std::size_t count = in.count(sizeof(std::uint64_t) + 1); count > 0; --count) {
    const auto frame = in.number<std::uint64_t>();
    last.push_back({frame, in.number<std::uint8_t>() != 0});
    areTrue = areTrue && frame >= firstFrame && frame < frames && last.size() <= maxCounted;
  }
  if (!areTrue) in.fail("a number of the lost drive is none", ErrorCode::corruptFile);
  const auto moments = [&] {
    return Moments::fromBytes(in.raw(Moments::byteCount(labels, true)), labels, true);
  };
  LostDrive drive(moments(), tauJoin, firstFrame, firstNode);
  drive.drive_ = moments();
  drive.last_ = std::move(last);
  std::tie(drive.alike_, drive.unlike_, drive.mapped_) = std::tuple_cat(counts);
  return drive;
}

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
    if (const double away = bank.distance(slot, seen.compared); away < least)
      least = away, nearest = bank[slot].moments().mean();
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
