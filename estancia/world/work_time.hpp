// Work time: whether a piece of work that is done again and again will end in time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

namespace estancia {

/// Until when; nothing where there is time enough.
using Deadline = std::optional<std::chrono::steady_clock::time_point>;

/// Expects work to take as long as it did of late (exponential smoothing). Work that is put off so often that
/// it would never be done is due, whatever it takes.
class WorkTime {
 public:
  /// `mostPutOff`: times in a row.
  explicit WorkTime(std::size_t mostPutOff) : mostPutOff_(mostPutOff) {}

  /// Whether to do it now; counts where not.
  bool isDue(const Deadline& deadline) {
    if (!deadline || Clock::now() + usual_ <= *deadline || putOff_ >= mostPutOff_) return true;
    ++putOff_;
    return false;
  }
  /// Does it.
  template <class Work>
  void run(const Work& work) {
    const auto begin = Clock::now();
    work();
    const Clock::duration taken = Clock::now() - begin;
    usual_ = usual_ == Clock::duration::zero() ? taken : usual_ + (taken - usual_) / smoothing;
    putOff_ = 0;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int smoothing = 8;

  std::size_t mostPutOff_, putOff_ = 0;
  Clock::duration usual_{};
};

}  // namespace estancia
