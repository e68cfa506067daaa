// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/frame_keeper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/map_file/drive_store.hpp"
#include "estancia/map_file/sqlite.hpp"

namespace estancia {
namespace {

/// Shares of the budget: where the file starts to be made smaller; the target, as far as sizes are known; and
/// what is small enough.
constexpr double fullAt = 0.96, smallerTo = 0.88, smallEnough = 0.92;
/// Share of the budget that is written before the size is checked, and limit of waiting frames in memory
/// [bytes].
constexpr double writtenBetween = 0.02;
constexpr std::size_t maxWaiting = 16'000'000;
/// Bytes of a row of room evidence of a frame's words, without the evidence itself.
constexpr int evidenceBytes = 12;
/// Frames that are left out between two commits: what is changed is in the file twice until then.
constexpr std::size_t slice = 1000;
/// Minimum information of a frame beside the mean of its place.
constexpr double minInformation = 0.05;

/// The further an image is from the mean of its place, the less of it is explained by the mean.
double informationOf(double toCurrent, double tauJoin) {
  const double share = toCurrent / tauJoin;
  return std::isfinite(share) ? std::clamp(share, minInformation, 1.0) : 1.0;
}

bool isIn(const std::vector<std::size_t>& sorted, std::size_t frame) {
  return std::ranges::binary_search(sorted, frame);
}

}  // namespace

bool FrameKeeper::takes(const Decision& decision) const {
  return sample_.takes(
      decision.node, FrameSample::keyOf(decision.frame, informationOf(decision.toCurrent, decision.tauJoin)));
}

void FrameKeeper::wait(Waiting frame) {
  waiting_.push_back(std::move(frame));
}

bool FrameKeeper::isDue() const {
  const std::size_t each = waiting_.empty() ? 0 : waiting_.back().descriptor.size() * sizeof(float);
  return waiting_.size() * (each + rowBytes) >= maxWaiting ||
         static_cast<double>(written_) >= writtenBetween * static_cast<double>(budget_);
}

std::vector<FrameKeeper::Waiting> FrameKeeper::takeNeeded(const std::vector<std::size_t>& needed) {
  std::vector<Waiting> taken;
  for (Waiting& waiting : std::exchange(waiting_, {}))
    if (isIn(needed, waiting.frame.number)) {
      borrowed_.insert(waiting.frame.number);
      taken.push_back(std::move(waiting));
    } else {
      leftOut_.insert(waiting.frame.number);
    }
  return taken;
}

void FrameKeeper::endWriting(const std::vector<std::size_t>& needed) {
  leftOut_.clear();
  std::vector<std::size_t> returned;
  std::ranges::set_difference(borrowed_, needed, std::back_inserter(returned));
  for (const std::size_t frame : returned) borrowed_.erase(frame);
  store_->leaveOut(returned);
}

std::vector<FrameSample::Entry> FrameKeeper::entries(const std::vector<std::size_t>& needed) const {
  std::vector<FrameSample::Entry> entries;
  const std::string ofRooms =
      sqlite::hasTable(store_->database(), "room_evidence")
          ? fmt::format(
                "(SELECT ifnull(sum(length(log_odds) + {}), 0) FROM room_evidence e WHERE e.frame = f.id)",
                evidenceBytes)
          : "0";
  sqlite::Statement rows(
      store_->database(),
      fmt::format(
          "SELECT f.id, f.node, d.to_current, d.tau_join, length(p.probabilities), ifnull(length(i.jpeg), 0) "
          "+ {} "
          "FROM frames f JOIN descriptors p ON p.frame = f.id LEFT JOIN decisions d ON d.frame = f.id "
          "LEFT JOIN images i ON i.frame = f.id ORDER BY f.id",
          ofRooms));
  while (rows.next()) {
    FrameSample::Entry entry;
    entry.frame = static_cast<std::size_t>(rows.integer(0));
    entry.node = static_cast<int>(rows.integer(1));
    entry.key = FrameSample::keyOf(entry.frame, informationOf(rows.real(2), rows.real(3)));
    entry.bytes = static_cast<std::uint64_t>(rows.integer(4) + rows.integer(5)) + rowBytes;
    entry.isNeeded = isIn(needed, entry.frame);
    entries.push_back(entry);
  }
  return entries;
}

bool FrameKeeper::isFull() const {
  return static_cast<double>(store_->bytes()) > fullAt * static_cast<double>(budget_);
}

void FrameKeeper::fit(const std::vector<std::size_t>& needed) {
  written_ = 0;
  const auto share = [this](double of) {
    return static_cast<std::uint64_t>(of * static_cast<double>(budget_));
  };
  if (!isFull()) return;
  const std::uint64_t target = share(smallerTo), enough = share(smallEnough);
  bool isCompact = false;
  for (std::uint64_t used = store_->bytes(); used > enough; used = store_->bytes()) {
    const std::vector<FrameSample::Entry> all = entries(needed);
    std::uint64_t ofFrames = 0;
    for (const FrameSample::Entry& entry : all) ofFrames += entry.bytes;
    const std::uint64_t excess = used - target;
    const auto gone = ofFrames > excess ? sample_.thin(all, ofFrames - excess) : std::nullopt;
    if (!gone || gone->empty()) {
      const auto least = static_cast<double>(used - ofFrames + FrameSample::minBytes(all)) / 1e6;
      fail(ErrorCode::tooLarge,
           "{}: its places, one image of each, and what must stay take {:.1f} MB; --file-budget {} is too "
           "small, "
           "give a larger one: {:.0f}",
           store_->database().path().string(), least, budget_ / 1'000'000, std::ceil(least / smallerTo) + 1);
    }
    for (std::size_t i = 0; i < gone->size(); i += slice) {
      store_->leaveOut({gone->begin() + static_cast<std::ptrdiff_t>(i),
                        gone->begin() + static_cast<std::ptrdiff_t>(std::min(i + slice, gone->size()))});
      store_->commit();
    }
    // Small rows leave pages that are not empty, which count as used.
    isCompact = !isCompact && store_->bytes() > enough;
    if (isCompact) store_->compact();
  }
}

std::vector<std::size_t> framesThatStay(MapStore& store) {
  std::set<std::size_t> frames;
  for (const Drive& drive : DriveStore(store).drives()) frames.insert(drive.firstFrame);
  if (const std::size_t count = store.frameCount(); count > 0) frames.insert(count - 1);
  if (sqlite::hasTable(store.database(), "observations")) {
    sqlite::Statement rows(store.database(), "SELECT frame FROM observations");
    while (rows.next()) frames.insert(static_cast<std::size_t>(rows.integer(0)));
  }
  return {frames.begin(), frames.end()};
}

}  // namespace estancia
