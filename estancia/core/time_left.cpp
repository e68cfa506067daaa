// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/time_left.hpp"

namespace estancia {

void TimeLeft::advance(std::size_t count, double now) {
  if (count == 0) return;
  done_ += count;
  if (firstTime_) return;
  firstTime_ = now;
  firstDone_ = done_;
}

std::optional<double> TimeLeft::rate(double now) const {
  if (!firstTime_ || now <= 0) return std::nullopt;
  if (isComplete()) return static_cast<double>(done_ - begun_) / now;
  const double since = now - *firstTime_;
  if (done_ == firstDone_ || since <= *firstTime_) return std::nullopt;
  return static_cast<double>(done_ - firstDone_) / since;
}

std::optional<double> TimeLeft::seconds(double now) const {
  const auto perSecond = rate(now);
  if (!perSecond || total_ == 0) return std::nullopt;
  return isComplete() ? 0 : static_cast<double>(total_ - done_) / *perSecond;
}

}  // namespace estancia
