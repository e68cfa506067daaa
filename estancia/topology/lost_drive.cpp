// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/lost_drive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace estancia {
namespace {

/// Keyframes: as many as a robot takes in a room. A kitchen resembles another building's.
constexpr std::size_t mostCounted = 100;

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

void LostDrive::count(double away) {
  isDue_ = false;
  last_.push_back(away < tauJoin_);
  if (last_.size() > mostCounted) last_.pop_front();
}

bool LostDrive::isRecognized() const {
  return 2 * std::ranges::count(last_, true) > std::ssize(last_);
}

std::string LostDrive::toBytes() const {
  ByteWriter out;
  out.number(tauJoin_);
  out.number<std::uint64_t>(firstFrame_);
  out.number<std::int32_t>(firstNode_);
  out.number<std::uint64_t>(last_.size());
  for (const bool resembles : last_) out.number<std::uint8_t>(resembles ? 1 : 0);
  for (const Moments* moments : {&map_, &drive_}) out.raw(moments->toBytes());
  return out.bytes();
}

LostDrive LostDrive::from(ByteReader& in, std::size_t labels, std::size_t frames, int nodes) {
  const auto tauJoin = in.number<double>();
  const auto firstFrame = in.number<std::uint64_t>();
  const auto firstNode = in.number<std::int32_t>();
  std::deque<bool> last;
  for (std::size_t count = in.count(1); count > 0; --count) last.push_back(in.number<std::uint8_t>() != 0);
  if (last.size() > mostCounted || firstFrame > frames || firstNode < 0 || firstNode > nodes ||
      !std::isfinite(tauJoin))
    in.fail("a number of the lost drive is none", ErrorCode::corruptFile);
  const auto moments = [&] {
    return Moments::fromBytes(in.raw(Moments::byteCount(labels, true)), labels, true);
  };
  LostDrive drive(moments(), tauJoin, firstFrame, firstNode);
  drive.drive_ = moments();
  drive.last_ = std::move(last);
  return drive;
}

}  // namespace estancia
