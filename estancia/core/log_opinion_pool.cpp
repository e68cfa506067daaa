// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/log_opinion_pool.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {
constexpr double minProbability = 0.001;
}

void LogOpinionPool::add(DescriptorView opinion) {
  if (opinion.size() != sums_.size())
    fail(ErrorCode::mismatch, "an opinion has {} answers; the pool needs {}", opinion.size(), sums_.size());
  if (std::ranges::all_of(opinion, [](float p) { return p <= 0; })) return;
  ++size_;
  for (std::size_t k = 0; k < sums_.size(); ++k)
    sums_[k] += std::log(std::max(minProbability, static_cast<double>(opinion[k])));
}

std::vector<double> LogOpinionPool::pooled() const {
  if (size_ == 0) return {};
  std::vector<double> pooled(sums_);
  for (double& value : pooled) value = std::exp(value / static_cast<double>(size_));
  const double total = std::accumulate(pooled.begin(), pooled.end(), 0.0);
  for (double& value : pooled) value /= total;
  return pooled;
}

}  // namespace estancia
