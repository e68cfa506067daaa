// Time left: how long work that is under way will still take.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

namespace estancia {

/// Estimates by the items that were finished after the first: what came before that was the start, too, as
/// opening the network. All times are in seconds since the work began.
class TimeLeft {
 public:
  /// `total` = 0: not known. `done`: by an earlier run.
  explicit TimeLeft(std::size_t total = 0, std::size_t done = 0) : total_(total), begun_(done), done_(done) {}

  void advance(std::size_t count, double now) {
    if (count == 0) return;
    done_ += count;
    if (firstTime_) return;
    firstTime_ = now;
    firstDone_ = done_;
  }

  std::size_t total() const { return total_; }
  std::size_t done() const { return done_; }
  bool isComplete() const { return total_ > 0 && done_ >= total_; }

  /// Items a second: averaged over complete work including its start. Absent as long as no estimate is
  /// possible: at most as much time has passed since the first item as before it, so that items of other
  /// threads, which are finished at about the same time, look like faster work.
  std::optional<double> rate(double now) const {
    if (!firstTime_ || now <= 0) return std::nullopt;
    if (isComplete()) return static_cast<double>(done_ - begun_) / now;
    const double since = now - *firstTime_;
    if (done_ == firstDone_ || since <= *firstTime_) return std::nullopt;
    return static_cast<double>(done_ - firstDone_) / since;
  }

  /// Absent also where the total is not known.
  std::optional<double> seconds(double now) const {
    const auto perSecond = rate(now);
    if (!perSecond || total_ == 0) return std::nullopt;
    return isComplete() ? 0 : static_cast<double>(total_ - done_) / *perSecond;
  }

 private:
  std::size_t total_, begun_, done_;
  /// Time of the first step that finished anything.
  std::optional<double> firstTime_;
  std::size_t firstDone_ = 0;
};

}  // namespace estancia
