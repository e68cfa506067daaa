// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/lost_drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

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

}  // namespace estancia
