// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/near_evidence.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

struct Gaussian {
  double mean = 0, sigma = 0;

  explicit Gaussian(const std::vector<float>& values) {
    const auto n = static_cast<double>(values.size());
    for (const float value : values) mean += value / n;
    for (const float value : values) sigma += (value - mean) * (value - mean) / n;
    sigma = std::sqrt(sigma);
  }
  double logDensity(double x) const { return -0.5 * std::pow((x - mean) / sigma, 2) - std::log(sigma); }
};

}  // namespace

NearEvidence::NearEvidence(const std::vector<float>& near, const std::vector<float>& far) {
  Gaussian ofNear(near), ofFar(far);
  // The spread of few or equal pairs would be 0, and one frame would decide everything.
  const double smallest = 0.05 * std::max(std::abs(ofFar.mean), 1e-6);
  for (Gaussian* gaussian : {&ofNear, &ofFar}) gaussian->sigma = std::max(gaussian->sigma, smallest);
  first_ = std::min(std::ranges::min(near), std::ranges::min(far));
  const double last = std::max(std::ranges::max(near), std::ranges::max(far));
  step_ = std::max(last - first_, 1e-9) / static_cast<double>(samples - 1);
  for (std::size_t i = 0; i < samples; ++i) {
    const double distance = first_ + step_ * static_cast<double>(i);
    log_.push_back(ofNear.logDensity(distance) - ofFar.logDensity(distance));
  }
  // A wide Gaussian of near pairs would make the largest distances speak for "near", too.
  const auto turning = std::ranges::min_element(log_);
  std::fill(turning, log_.end(), *turning);
  for (auto i = log_.rbegin() + 1; i != log_.rend(); ++i) *i = std::max(*i, *(i - 1));
}

double NearEvidence::ratio(double distance) const {
  const double at = std::clamp((distance - first_) / step_, 0.0, static_cast<double>(samples - 1));
  const auto below = std::min(static_cast<std::size_t>(at), samples - 2);
  return std::exp(std::lerp(log_[below], log_[below + 1], at - static_cast<double>(below)));
}

}  // namespace estancia
