// Work time: whether a piece of work that is done again and again will end in time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

namespace estancia {

/// Until when; nothing where there is time enough.
using Deadline = std::optional<std::chrono::steady_clock::time_point>;

/// Expects work to take as long as of late (exponential smoothing); what was done too long ago is due.
class WorkTime {
 public:
  using Clock = std::chrono::steady_clock;

  /// `longest`: from one time to the next, where there is work.
  explicit WorkTime(Clock::duration longest) : longest_(longest) {}

  /// Whether to do it now.
  bool isDue(const Deadline& deadline) const {
    const auto now = Clock::now();
    return !deadline || now + usual_ <= *deadline || !begun_ || now - *begun_ >= longest_;
  }
  /// Does it.
  template <class Work>
  void run(const Work& work) {
    begun_ = Clock::now();
    work();
    const Clock::duration taken = Clock::now() - *begun_;
    usual_ = usual_ == Clock::duration::zero() ? taken : usual_ + (taken - usual_) / smoothing;
  }

 private:
  static constexpr int smoothing = 8;

  Clock::duration longest_, usual_{};
  std::optional<Clock::time_point> begun_;
};

}  // namespace estancia
