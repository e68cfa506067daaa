// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/frame_keeper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/map_file/sqlite.hpp"

namespace estancia {
namespace {

/// A number in (0, 1) that looks random: the finalizer of SplitMix64 (Steele, Lea & Flood 2014).
double scrambled(std::uint64_t number) {
  number += 0x9e3779b97f4a7c15;
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9;
  number = (number ^ (number >> 27)) * 0x94d049bb133111eb;
  number ^= number >> 31;
  return (static_cast<double>(number >> 11) + 0.5) * 0x1p-53;
}

/// The entries of each place, smallest keys first.
std::map<int, std::vector<FrameSample::Entry>> byPlace(const std::vector<FrameSample::Entry>& entries) {
  std::map<int, std::vector<FrameSample::Entry>> places;
  for (const FrameSample::Entry& entry : entries) places[entry.node].push_back(entry);
  for (auto& [node, own] : places) std::ranges::sort(own, {}, &FrameSample::Entry::key);
  return places;
}

/// The bytes of the first `most` entries of each place, and of all needed ones.
std::uint64_t bytesOf(const std::map<int, std::vector<FrameSample::Entry>>& places, std::size_t most) {
  std::uint64_t bytes = 0;
  for (const auto& [node, entries] : places)
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (i < most || entries[i].isNeeded) bytes += entries[i].bytes;
  return bytes;
}

/// Shares of the budget: where the file is made smaller, what it is to have, and what is small enough.
constexpr double fullAt = 0.96, smallerTo = 0.88, smallEnough = 0.92;
/// Share of the budget written before the size is checked, and limit of waiting frames in memory [bytes].
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

}  // namespace

double FrameSample::keyOf(std::size_t frame, double information) {
  return -std::log(scrambled(frame)) / information;
}

bool FrameSample::takes(int node, double key) const {
  const auto bound = bounds_.find(node);
  return bound == bounds_.end() || key < bound->second;
}

std::uint64_t FrameSample::minBytes(const std::vector<Entry>& entries) {
  return bytesOf(byPlace(entries), 1);
}

std::optional<std::vector<std::size_t>> FrameSample::thin(const std::vector<Entry>& entries,
                                                          std::uint64_t bytes) {
  const std::map<int, std::vector<Entry>> places = byPlace(entries);
  std::size_t most = 0;
  for (const auto& [node, own] : places) most = std::max(most, own.size());
  if (bytesOf(places, 1) > bytes) return std::nullopt;
  std::size_t fits = 1;  // most frames of a place that fit: bytesOf() grows with it
  for (std::size_t end = most + 1; end - fits > 1;) {
    const std::size_t middle = std::midpoint(fits, end);
    (bytesOf(places, middle) <= bytes ? fits : end) = middle;
  }
  std::vector<std::size_t> gone;
  for (const auto& [node, own] : places) {
    if (own.size() <= fits) continue;
    for (std::size_t i = fits; i < own.size(); ++i)
      if (!own[i].isNeeded) gone.push_back(own[i].frame);
    double& bound = bounds_.try_emplace(node, own[fits].key).first->second;
    bound = std::min(bound, own[fits].key);
  }
  std::ranges::sort(gone);
  return gone;
}

std::string FrameSample::state() const {
  ByteWriter out;
  out.number<std::uint64_t>(bounds_.size());
  for (const auto& [node, bound] : bounds_) {
    out.number<std::int32_t>(node);
    out.number(bound);
  }
  return out.bytes();
}

void FrameSample::restore(ByteReader& in) {
  bounds_.clear();
  for (std::size_t count = in.count(sizeof(std::int32_t) + sizeof(double)); count > 0; --count) {
    const auto node = in.number<std::int32_t>();
    bounds_[node] = in.number<double>();
  }
}

bool FrameKeeper::takes(const Decision& decision) const {
  return sample_.takes(
      decision.node, FrameSample::keyOf(decision.frame, informationOf(decision.toCurrent, decision.tauJoin)));
}

bool FrameKeeper::isDue() const {
  const std::size_t each = waiting_.empty() ? 0 : waiting_.back().descriptor.size() * sizeof(float);
  return waiting_.size() * (each + rowBytes) >= maxWaiting ||
         static_cast<double>(written_) >= writtenBetween * static_cast<double>(budget_);
}

std::vector<FrameKeeper::Waiting> FrameKeeper::takeNeeded(const std::vector<std::size_t>& needed) {
  std::vector<Waiting> taken;
  for (Waiting& waiting : std::exchange(waiting_, {}))
    if (std::ranges::binary_search(needed, waiting.frame.number)) {
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
          "+ {} FROM frames f JOIN descriptors p ON p.frame = f.id LEFT JOIN decisions d ON d.frame = f.id "
          "LEFT JOIN images i ON i.frame = f.id ORDER BY f.id",
          ofRooms));
  while (rows.next()) {
    const auto frame = static_cast<std::size_t>(rows.integer(0));
    entries.push_back({frame, static_cast<int>(rows.integer(1)),
                       FrameSample::keyOf(frame, informationOf(rows.real(2), rows.real(3))),
                       static_cast<std::uint64_t>(rows.integer(4) + rows.integer(5)) + rowBytes,
                       std::ranges::binary_search(needed, frame)});
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
           "small, give a larger one: {:.0f}",
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
  for (const Drive& drive : store.drives()) frames.insert(drive.firstFrame);
  if (const std::size_t count = store.frameCount(); count > 0) frames.insert(count - 1);
  if (sqlite::hasTable(store.database(), "observations")) {
    const std::vector<std::size_t> observed = store.database().numbers("SELECT frame FROM observations");
    frames.insert(observed.begin(), observed.end());
  }
  return {frames.begin(), frames.end()};
}

}  // namespace estancia
