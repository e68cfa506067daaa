// Logarithmic opinion pool: fuses several probability vectors of one object.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {

/// The normalized geometric mean of probabilities (Genest and Zidek 1986, Combining probability
/// distributions). Images of one place or object follow each other and err together: their plain product
/// would count the same evidence repeatedly and be overconfident; the mean does not change when images
/// repeat. Probabilities count as at least 0.001: the 0 of a forest or of nearest neighbors is no proof.
class LogOpinionPool {
 public:
  /// Pools opinions about so many answers.
  explicit LogOpinionPool(std::size_t answers) : sums_(answers, 0) {}

  /// An opinion of zeros is ignored. Throws Error (mismatch) on another number of answers.
  void add(DescriptorView opinion) {
    if (opinion.size() != sums_.size())
      fail(ErrorCode::mismatch, "an opinion has {} answers; the pool needs {}", opinion.size(), sums_.size());
    if (std::ranges::all_of(opinion, [](float p) { return p <= 0; })) return;
    constexpr double minProbability = 0.001;
    ++size_;
    for (std::size_t k = 0; k < sums_.size(); ++k)
      sums_[k] += std::log(std::max(minProbability, static_cast<double>(opinion[k])));
  }

  std::size_t size() const { return size_; }

  /// Adds up to 1; empty without any opinion.
  std::vector<double> pooled() const {
    if (size_ == 0) return {};
    std::vector<double> pooled(sums_);
    for (double& value : pooled) value = std::exp(value / static_cast<double>(size_));
    const double total = std::accumulate(pooled.begin(), pooled.end(), 0.0);
    for (double& value : pooled) value /= total;
    return pooled;
  }

 private:
  std::vector<double> sums_;  // sums of logarithms
  std::size_t size_ = 0;
};

}  // namespace estancia
