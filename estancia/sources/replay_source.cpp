// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/replay_source.hpp"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include "estancia/core/frame_failure.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/session/session.hpp"

namespace estancia {
namespace {

/// A pause of more is a clock that was set, or a recording that was stopped and taken up again.
constexpr double longestPause = 5;  // [s]

/// From a frame to the next by their time stamps; nothing if they are not usable.
std::optional<double> pauseBetween(const Frame& a, const Frame& b) {
  if (!a.timestamp || !b.timestamp) return std::nullopt;
  const double pause = *b.timestamp - *a.timestamp;
  return pause > 0 && pause <= longestPause ? std::optional(pause) : std::nullopt;
}

/// The median pause between the time stamps of the first frames.
double usualPause(const Sequence& sequence, double otherwise) {
  std::vector<double> pauses;
  for (std::size_t i = 1; i < std::min<std::size_t>(1000, sequence.size()); ++i)
    if (const auto pause = pauseBetween(sequence.frame(i - 1), sequence.frame(i))) pauses.push_back(*pause);
  if (pauses.empty()) return otherwise;
  const auto middle = pauses.begin() + static_cast<std::ptrdiff_t>(pauses.size() / 2);
  std::nth_element(pauses.begin(), middle, pauses.end());
  return *middle;
}

}  // namespace

OptionGroup declare(ReplayOptions& options) {
  OptionGroup group("replay", "How a recording is played.");
  group.add("rate", &options.rate, "Play so many times as fast as it was recorded.")
      .range(0, 1000)
      .why("0 plays as fast as frames are taken, so that none is dropped.");
  group.add("frames-per-second", &options.framesPerSecond, "Of recordings without time stamps.")
      .unit("Hz")
      .range(0.001, 1000);
  return group;
}

ReplaySource::ReplaySource(std::unique_ptr<Sequence> sequence, const ReplayOptions& options)
    : sequence_(std::move(sequence)), options_(options) {
  declare(options_).validate();
  period_ = usualPause(*sequence_, 1 / options_.framesPerSecond);
  hasPoses_ = estancia::hasPoses(*sequence_);
}

bool ReplaySource::goOnAfter(const TopologicalMap& map) {
  const auto next = firstUnmapped(map, *sequence_);
  next_ = next.value_or(0);
  return next.has_value();
}

/// Pause before a frame as it was recorded [s].
double ReplaySource::pauseBefore(std::size_t frame) const {
  return pauseBetween(sequence_->frame(frame - 1), sequence_->frame(frame)).value_or(period_);
}

std::optional<LiveFrame> ReplaySource::newest(std::chrono::milliseconds patience) {
  if (ended()) return std::nullopt;
  const Clock::time_point now = Clock::now();
  if (!std::exchange(started_, true)) due_ = now;
  if (options_.rate <= 0) {
    due_ = now;
    return read(next_++);
  }
  if (due_ > now) {
    std::this_thread::sleep_until(std::min(due_, now + patience));
    if (Clock::now() < due_) return std::nullopt;
  }
  std::size_t newest = next_;
  Clock::time_point due = due_, after = due;
  for (const Clock::time_point then = Clock::now();; ++newest) {
    if (newest + 1 == sequence_->size()) break;
    const std::chrono::duration<double> pause(pauseBefore(newest + 1) / options_.rate);
    after = due + std::chrono::duration_cast<Clock::duration>(pause);
    if (after > then) break;
    due = after;
  }
  dropped_ += newest - next_;
  next_ = newest + 1;
  auto frame = read(newest);
  due_ = after;
  if (!frame) return std::nullopt;
  frame->arrived = due;
  frame->dropped = std::exchange(dropped_, 0);
  return frame;
}

std::optional<LiveFrame> ReplaySource::read(std::size_t i) {
  LiveFrame live;
  live.frame = sequence_->frame(i);
  live.arrived = Clock::now();
  std::string trouble;
  try {
    live.image = sequence_->image(i);
  } catch (...) {
    ++unreadable_;
    say(frameFailure(live.frame.name).what());
    return std::nullopt;
  }
  if (hasDepth()) try {
      live.depth = sequence_->depth(i);
    } catch (...) {
      trouble = std::string("no depth: ") + frameFailure(live.frame.name).what();
    }
  say(trouble);
  return live;
}

void ReplaySource::say(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  trouble_ = trouble;
}

std::string ReplaySource::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

}  // namespace estancia
