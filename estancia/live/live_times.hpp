// Live times: latency, forward pass, rate and period of the last frames, in constant memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace estancia {

/// The last 1,000 numbers.
class RecentNumbers {
 public:
  void add(double value) {
    if (values_.size() < most)
      values_.push_back(value);
    else
      values_[next_++ % most] = value;
  }
  /// Quantile `p` of the numbers; 0 without any.
  double quantile(double p) const {
    if (values_.empty()) return 0;
    std::vector<double> sorted = values_;
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
  }

 private:
  static constexpr std::size_t most = 1000;
  std::vector<double> values_;
  std::size_t next_ = 0;
};

/// Frames a second, over the last ten.
class RecentRate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  void add(Time now) {
    times_.push_back(now);
    if (times_.size() > most) times_.erase(times_.begin());
  }
  /// 0 before the second frame.
  double value() const {
    if (times_.size() < 2) return 0;
    const std::chrono::duration<double> span = times_.back() - times_.front();
    return span.count() > 0 ? static_cast<double>(times_.size() - 1) / span.count() : 0;
  }

 private:
  static constexpr std::size_t most = 11;
  std::vector<Time> times_;
};

/// The time between two frames of a camera, those that were dropped included: the median of the last ones.
class FramePeriod {
 public:
  using Time = std::chrono::steady_clock::time_point;
  void add(Time arrived, std::size_t dropped) {
    if (last_) {
      if (gaps_.size() == most) gaps_.erase(gaps_.begin());
      gaps_.push_back((arrived - *last_) / static_cast<std::int64_t>(dropped + 1));
    }
    last_ = arrived;
  }
  /// Nothing before there are some.
  std::optional<Time::duration> value() const {
    if (gaps_.size() < least) return std::nullopt;
    std::vector<Time::duration> sorted = gaps_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    return *middle;
  }

 private:
  static constexpr std::size_t least = 3, most = 15;
  std::optional<Time> last_;
  std::vector<Time::duration> gaps_;
};

}  // namespace estancia
