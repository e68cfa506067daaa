// Logarithmic opinion pool: fuses several probability vectors of one object.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// The normalized geometric mean of probabilities (Genest and Zidek 1986, Combining probability
/// distributions). Images of one place or object follow each other and err together: their plain product
/// would count the same evidence repeatedly and be overconfident; the mean does not change when images
/// repeat. Probabilities count as at least 0.001: the 0 of a random forest or of k nearest neighbors is no
/// proof.
class LogOpinionPool {
 public:
  /// Pools opinions about so many answers.
  explicit LogOpinionPool(std::size_t answers) : sums_(answers, 0) {}

  /// An opinion of zeros is ignored. Throws Error (mismatch) on another number of answers.
  void add(DescriptorView opinion);

  std::size_t size() const { return size_; }

  /// Adds up to 1; empty without any opinion.
  std::vector<double> pooled() const;

 private:
  std::vector<double> sums_;  // sums of logarithms
  std::size_t size_ = 0;
};

}  // namespace estancia
